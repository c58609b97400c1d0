/** What a press and a drag on the floor say: a goal with its heading, or a distance. */

import type { Point, Values } from "../api";

/** A goal of a robot as an event of the world file; without a heading where the drag was shorter than `least` [m]. */
export function goalEvent(robot: string, from: Point, to: Point, least: number): Values {
  const [along, aside] = [to[0] - from[0], to[1] - from[1]];
  const heading =
    Math.hypot(along, aside) < least ? {} : { heading_deg: rounded((Math.atan2(aside, along) * 180) / Math.PI, 10) };
  return { goal: robot, to: from.map((value) => rounded(value, 1000)), ...heading };
}

/** A distance, and its direction [deg, counter-clockwise from x]. */
export function measured(from: Point, to: Point): { metres: string; degrees: string } {
  const [along, aside] = [to[0] - from[0], to[1] - from[1]];
  const degrees = (Math.atan2(aside, along) * 180) / Math.PI;
  return { metres: Math.hypot(along, aside).toFixed(3), degrees: degrees.toFixed(1).replace(/^-(?=0\.0$)/, "") };
}

function rounded(value: number, parts: number): number {
  // Without a negative zero.
  return Math.round(value * parts) / parts + 0;
}
