/** Tools of arms on the plan of a run: handles that lead them by inverse kinematics. */

import type { Point, Values } from "../api";
import type { PlanView } from "../plan/view";
import type { Lead, Led, Place } from "../scene/grip";
import type { Tokens } from "../ui/ink";
import { type Change, gripAfter, type HeldJoint, showsOnPlan, still } from "./joint_grips";
import type { Standing, Touchable } from "./touch";

/** Half the side of a handle [px]. */
const HALF = 5;

/** Where the hands of people are, by person and side [m]. */
export type Hands = Record<string, Record<string, Place>>;

/** Whose hand it is. */
export interface HeldHand {
  person: string;
  side: string;
  /** Above the floor [m]. */
  z: number;
}

/** Whose tool it is. */
export interface HeldTool {
  robot: Standing;
  arm: string;
  /** Above the robot's origin [m]. */
  z: number;
}

export type Held = HeldTool | HeldHand | HeldJoint;

/** All hands, where they are. */
function handsOf(hands: Hands): Touchable[] {
  return Object.entries(hands).flatMap(([person, sides]) =>
    Object.entries(sides).map(([side, [x, y, z]]): Touchable => {
      return { name: `${person}/${side}`, at: [x, y], heading_deg: 0, radius: 0, held: { person, side, z } };
    }),
  );
}

/** The same, for the view in 3-D; `noteOf` gives what is written beside one. */
export function handLeads(hands: Hands, noteOf: (hand: string) => string | undefined): Lead[] {
  return Object.entries(hands).flatMap(([person, sides]) =>
    Object.entries(sides).map(([side, at]): Lead => {
      const key = JSON.stringify([person, "", side]);
      return { key, body: "", stands: [0, 0, 0], at, note: noteOf(`${person}/${side}`) };
    }),
  );
}

/** The tools of all arms, all hands, and the joints that are seen to move from above. */
export function toolsOf(robots: Standing[], hands: Hands, joints: HeldJoint[]): Touchable[] {
  return [...armTools(robots), ...handsOf(hands), ...joints.filter(({ grip }) => showsOnPlan(grip)).map(jointTool)];
}

function jointTool(held: HeldJoint): Touchable {
  const { of, joint, grip } = held.grip;
  return { name: `${of}.${joint}`, at: [grip[0], grip[1]], heading_deg: 0, radius: 0, held };
}

/** The same, for the view in 3-D. */
export function jointLeads(joints: HeldJoint[]): Lead[] {
  return joints.map((joint) => {
    const { of, joint: name, grip } = joint.grip;
    return { key: JSON.stringify([of, "", "", name]), body: "", stands: [0, 0, 0], at: grip, joint };
  });
}

function armTools(robots: Standing[]): Touchable[] {
  return robots.flatMap((robot) =>
    Object.entries(robot.tick.arms ?? {}).map(([arm, { tool }]): Touchable => {
      const [x = 0, y = 0, z = 0, , , yaw = 0] = tool;
      const [left, top, heading] = robot.pose;
      const at: Point = [
        left + x * Math.cos(heading) - y * Math.sin(heading),
        top + x * Math.sin(heading) + y * Math.cos(heading),
      ];
      return {
        name: `${robot.name}/${arm}`,
        at,
        heading_deg: ((heading + yaw) * 180) / Math.PI,
        radius: 0,
        held: { robot, arm, z },
      };
    }),
  );
}

/** The same, for the view in 3-D: in the frames of their robots. */
export function toolLeads(robots: Standing[], noteOf: (tool: string) => string | undefined): Lead[] {
  return robots.flatMap(({ name, pose, tick }) =>
    Object.entries(tick.arms ?? {}).map(([arm, { tool }]): Lead => {
      const [x = 0, y = 0, z = 0] = tool;
      return {
        key: JSON.stringify([name, arm]),
        body: `${name}/base`,
        stands: pose,
        at: [x, y, z],
        note: noteOf(`${name}/${arm}`),
      };
    }),
  );
}

/** The event that takes a tool where it was led in 3-D. */
export function ledEvent({ key, to }: Led): Values {
  const [reach, arm, hand] = JSON.parse(key) as [string, string, string?];
  if (hand) return { reach, hand, to: to.map(rounded) };
  return { reach, arm, tool: to.map(rounded) };
}

/** The event that takes a tool to a place of the plan, as high as it is. */
export function reachEvent(held: HeldTool | HeldHand, [x, y]: Point): Values {
  if ("person" in held) return { reach: held.person, hand: held.side, to: [x, y, held.z].map(rounded) };
  const { robot, arm, z } = held;
  const [left, top, heading] = robot.pose;
  const [along, aside] = [x - left, y - top];
  const tool = [
    along * Math.cos(heading) + aside * Math.sin(heading),
    aside * Math.cos(heading) - along * Math.sin(heading),
    z,
  ];
  return { reach: robot.name, arm, tool: tool.map(rounded) };
}

function rounded(value: number): number {
  return Math.round(value * 1e4) / 1e4;
}

/** Draw a handle at each tool and hand, and a round one at each joint, with the line to its axis. */
export function drawTools(
  context: CanvasRenderingContext2D,
  tools: Touchable[],
  view: PlanView,
  palette: Tokens,
): void {
  for (const { at, held } of tools) {
    const [x, y] = view.toScreen(at);
    context.lineWidth = 2;
    context.fillStyle = palette.paper;
    context.strokeStyle = palette.accent;
    if (held && "grip" in held) {
      drawJoint(context, held, view, still(held));
      continue;
    }
    context.fillRect(x - HALF, y - HALF, 2 * HALF, 2 * HALF);
    context.strokeRect(x - HALF, y - HALF, 2 * HALF, 2 * HALF);
  }
}

/** Draw the handle of a joint once it was moved. */
export function drawJoint(context: CanvasRenderingContext2D, { grip }: HeldJoint, view: PlanView, by: Change): void {
  const [x, y] = gripAfter(grip, by);
  const end = view.toScreen([x, y]);
  context.beginPath();
  context.moveTo(...view.toScreen([grip.at[0], grip.at[1]]));
  context.lineTo(...end);
  context.stroke();
  context.beginPath();
  context.arc(...end, HALF, 0, 2 * Math.PI);
  context.fill();
  context.stroke();
}
