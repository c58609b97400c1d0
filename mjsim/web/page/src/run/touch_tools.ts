/** Tools of arms on the plan of a run: handles that lead them by inverse kinematics. */

import type { Point, Values } from "../api";
import type { Palette } from "../plan/palette";
import type { PlanView } from "../plan/view";
import type { Lead, Led } from "../scene/grip";
import type { Standing, Touchable } from "./touch";

/** Half the side of a handle [px]. */
const HALF = 5;

/** Whose tool it is. */
export interface Held {
  robot: Standing;
  arm: string;
  /** Above the robot's origin [m]. */
  z: number;
}

/** The tools of all arms, where they are. */
export function toolsOf(robots: Standing[]): Touchable[] {
  return robots.flatMap((robot) =>
    Object.entries(robot.tick.arms ?? {}).map(([arm, { tool }]): Touchable => {
      const [x = 0, y = 0, z = 0, , , yaw = 0] = tool;
      const [left, top, heading] = robot.pose;
      const at: Point = [left + x * Math.cos(heading) - y * Math.sin(heading), top + x * Math.sin(heading) + y * Math.cos(heading)];
      return { name: `${robot.name}/${arm}`, at, heading_deg: ((heading + yaw) * 180) / Math.PI, radius: 0, held: { robot, arm, z } };
    }),
  );
}

/** The same, for the view in 3-D: in the frames of their robots. */
export function toolLeads(robots: Standing[]): Lead[] {
  return robots.flatMap(({ name, pose, tick }) =>
    Object.entries(tick.arms ?? {}).map(([arm, { tool }]): Lead => {
      const [x = 0, y = 0, z = 0] = tool;
      return { key: JSON.stringify([name, arm]), body: `${name}/base`, stands: pose, at: [x, y, z] };
    }),
  );
}

/** The event that takes a tool where it was led in 3-D. */
export function ledEvent({ key, to }: Led): Values {
  const [reach, arm] = JSON.parse(key) as [string, string];
  return { reach, arm, tool: to.map(rounded) };
}

/** The event that takes a tool to a place of the plan, as high as it is. */
export function reachEvent({ robot, arm, z }: Held, [x, y]: Point): Values {
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

/** Draw a handle at each tool. */
export function drawTools(context: CanvasRenderingContext2D, robots: Standing[], view: PlanView, palette: Palette): void {
  for (const { at } of toolsOf(robots)) {
    const [x, y] = view.toScreen(at);
    context.lineWidth = 2;
    context.fillStyle = palette.paper;
    context.strokeStyle = palette.accent;
    context.fillRect(x - HALF, y - HALF, 2 * HALF, 2 * HALF);
    context.strokeRect(x - HALF, y - HALF, 2 * HALF, 2 * HALF);
  }
}
