/** What is drawn over the plan while it is edited. */

import type { Item, Point, Values } from "../api";
import { add, boundsOf, rotate } from "../plan/geometry";
import { keyOf, type Plan } from "../plan/plan";

/** How far a camera's view is drawn [m]. */
const SIGHT = 3;

/** What the cameras of a robot have in view. */
export function paintViews(context: CanvasRenderingContext2D, plan: Plan, robot: Item): void {
  const sensors = robot.values["sensors"];
  if (robot.type !== "Robot" || !robot.at || !Array.isArray(sensors)) return;
  const turn = robot.heading_deg ?? 0;
  for (const sensor of sensors as Values[]) {
    const at = sensor["at"];
    // The plan does not know the pose of a camera on an arm.
    if (typeof sensor["camera"] !== "string" || !Array.isArray(at) || typeof sensor["on"] === "string") continue;
    const middle = plan.view.toScreen(add(robot.at, rotate([Number(at[0]), Number(at[1])], turn)));
    paintWedge(context, plan, middle, turn + Number(sensor["yaw_deg"] ?? 0), Number(sensor["fov_deg"] ?? 60));
  }
}

function paintWedge(
  context: CanvasRenderingContext2D,
  plan: Plan,
  middle: Point,
  heading: number,
  field: number,
): void {
  const reach = SIGHT * plan.view.scale;
  const shade = context.createRadialGradient(...middle, 0, ...middle, reach);
  shade.addColorStop(0, plan.palette.accent);
  shade.addColorStop(1, "transparent");
  const start = (-(heading + field / 2) * Math.PI) / 180;
  context.save();
  context.globalAlpha = 0.3;
  context.fillStyle = shade;
  context.beginPath();
  context.moveTo(...middle);
  context.arc(...middle, reach, start, start + (field * Math.PI) / 180);
  context.closePath();
  context.fill();
  context.restore();
}

/** A few words beside the pointer. */
export function paintNote(context: CanvasRenderingContext2D, plan: Plan, [x, y]: Point, text: string): void {
  context.font = "600 12px system-ui, sans-serif";
  context.textBaseline = "middle";
  context.textAlign = "left";
  const width = context.measureText(text).width;
  const left = Math.min(x + 16, plan.view.width - width - 20);
  context.fillStyle = plan.palette.ink;
  context.beginPath();
  context.roundRect(left, y - 32, width + 16, 22, 5);
  context.fill();
  context.fillStyle = plan.palette.paper;
  context.fillText(text, left + 8, y - 20.5);
}

/** The rubber band between two corners. */
export function paintBand(context: CanvasRenderingContext2D, plan: Plan, a: Point, b: Point): void {
  context.strokeStyle = plan.palette.accent;
  context.fillStyle = plan.palette.accent;
  context.lineWidth = 1;
  context.globalAlpha = 0.12;
  context.fillRect(a[0], a[1], b[0] - a[0], b[1] - a[1]);
  context.globalAlpha = 1;
  context.strokeRect(a[0], a[1], b[0] - a[0], b[1] - a[1]);
}

/** A dashed frame around things that are one group, as a drag has them. */
export function paintFrame(context: CanvasRenderingContext2D, plan: Plan, group: Item[]): void {
  const shown = group.map((item) => plan.ghosts.get(keyOf(item.path)) ?? item);
  const points = shown.flatMap((item) => [...item.polygons.flat(), ...(item.at ? [item.at] : [])]);
  if (!points.length) return;
  const [x0, y0, x1, y1] = boundsOf(points.map((point) => plan.view.toScreen(point)));
  context.save();
  context.lineWidth = 1;
  context.setLineDash([5, 4]);
  context.strokeRect(x0 - 6, y0 - 6, x1 - x0 + 12, y1 - y0 + 12);
  context.restore();
}
