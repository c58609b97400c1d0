/** From how far all corners of a box are seen, and where axes point in a view. */

import { crossed, dot, inverse, product, type Quaternion, times } from "../run/rotations";
import type { Place } from "./grip";

/** Room around them. */
const SPARE = 1.06;

/**
 * Return the least distance from the middle of a box [m] at which its corners are in the picture.
 *
 * `size`: lengths of its sides [m]; `from`: direction from the middle to the eye; `across`, `up`: half of the picture's
 * width and height at a distance of 1.
 */
export function distanceToSee(size: Place, from: Place, across: number, up: number): number {
  const back = times(from, 1 / Math.hypot(...from));
  const level = Math.hypot(back[0], back[1]);
  // Straight from above, east is to the right.
  const right: Place = level < 1e-3 ? [1, 0, 0] : [-back[1] / level, back[0] / level, 0];
  const above = crossed(back, right);
  const distances = [0, 1, 2, 3, 4, 5, 6, 7].map((k) => {
    const corner: Place = [
      (k & 1 ? 0.5 : -0.5) * size[0],
      (k & 2 ? 0.5 : -0.5) * size[1],
      (k & 4 ? 0.5 : -0.5) * size[2],
    ];
    return (
      SPARE * Math.max(Math.abs(dot(corner, right)) / across, Math.abs(dot(corner, above)) / up) + dot(corner, back)
    );
  });
  return Math.max(...distances);
}

/** Where the ends of x, y and z are seen: to the right, down, and towards the eye; each has a length of 1. */
export function endsOf(eye: Quaternion): Place[] {
  const axes: Place[] = [
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
  ];
  return axes.map((axis) => {
    const [, x, y, z] = product(product(inverse(eye), [0, ...axis]), eye);
    return [x, -y, z];
  });
}
