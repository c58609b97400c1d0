/** What is held by hand on the plan of a run, and how it is drawn where it is to be. */

import type { Point } from "../api";
import { length, minus } from "../plan/geometry";
import type { PlanView } from "../plan/view";
import type { Tokens } from "../ui/ink";
import { type Change, gripAfter, type HeldJoint, jointAfter, jointSaid, type LetGo } from "./joint_grips";
import type { Touchable } from "./touch";
import { drawJoint } from "./touch_tools";

/** What is drawn on. */
interface Sheet {
  view: PlanView;
  palette: Tokens;
}

/** A push by a drag with Shift [N s for a metre]. */
export const PER_METRE = 10;

export interface Grab {
  thing: Touchable;
  /** Where it is to be. */
  to: Point;
  /** Where the pointer took it; null by keys. */
  from: Point | null;
  push: boolean;
  /** The joint that is held, as it is now, and by how much it is to move. */
  joint: HeldJoint | null;
  by: Change;
  /** Where the robot of a tool or of a joint stood when a target was sent. */
  stood: string;
  /** Of a joint that was let go and goes on to where that was. */
  letGo?: LetGo | null;
}

/** The thing as it would stand, and the way there from where it is now; an arrow for a push. */
export function drawGrab(context: CanvasRenderingContext2D, grab: Grab, now: Point, { view, palette }: Sheet): void {
  const [from, to] = [view.toScreen(now), view.toScreen(grab.to)];
  context.strokeStyle = palette.accent;
  context.lineWidth = 2;
  const { joint } = grab;
  if (joint) {
    context.fillStyle = palette.accent;
    drawJoint(context, joint, view, grab.by);
    const [x, y] = gripAfter(joint.grip, grab.by);
    return letters(context, jointSaid(jointAfter(joint, grab.by)).join(" "), view.toScreen([x, y]), palette);
  }
  context.setLineDash(grab.push ? [] : [5, 4]);
  context.beginPath();
  context.moveTo(...from);
  context.lineTo(...to);
  context.stroke();
  if (grab.push) arrowHead(context, from, to);
  else {
    context.beginPath();
    context.arc(...to, Math.max(grab.thing.radius * view.scale, 6), 0, 2 * Math.PI);
    context.stroke();
  }
  context.setLineDash([]);
  const way = minus(grab.to, grab.thing.at);
  const place = grab.to.map((value) => value.toFixed(2)).join(", ");
  letters(
    context,
    grab.push ? `${(length(way) * PER_METRE).toFixed(1)} N s` : `${grab.thing.name}  ${place}`,
    to,
    palette,
  );
}

/** Write beside a place of the plan. */
export function letters(context: CanvasRenderingContext2D, text: string, [x, y]: Point, palette: Tokens): void {
  context.font = "12px system-ui, sans-serif";
  context.lineWidth = 3;
  context.strokeStyle = palette.paper;
  context.strokeText(text, x + 12, y - 12);
  context.fillStyle = palette.ink;
  context.fillText(text, x + 12, y - 12);
}

function arrowHead(context: CanvasRenderingContext2D, from: Point, to: Point): void {
  const angle = Math.atan2(to[1] - from[1], to[0] - from[0]);
  context.beginPath();
  for (const side of [-0.5, 0.5]) {
    context.moveTo(...to);
    context.lineTo(to[0] - 10 * Math.cos(angle + side), to[1] - 10 * Math.sin(angle + side));
  }
  context.stroke();
}
