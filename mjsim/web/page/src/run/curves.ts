/** Points on curves that a hand moves: where on its curve one is, and which place is seen nearest to the pointer. */

import type { Point } from "../api";
import type { Place } from "../scene/grip";
import type { JointGrip } from "./protocol";
import { minus, plus, times } from "./rotations";

/** So much farther from the pointer a place may be seen, as a share of the curve's size, for a whole round less to go. */
const NEARER = 0.02;

/** Where the handle is once its point has gone so far along the curve [m]. */
export function curveAfter(grip: JointGrip, by: number): Place {
  if (by === 0) return grip.grip;
  const places = placesOf(grip);
  const last = places.length - 1;
  const share = shareOf(grip, by) * last;
  const k = Math.min(Math.floor(share), last - 1);
  const [from, to] = [places[k] ?? grip.grip, places[k + 1] ?? grip.grip];
  return plus(from, times(minus(to, from), share - k));
}

/** How far the point is to go to where its curve is seen nearest to a place of a picture; the shortest way [m]. */
export function curveTo(grip: JointGrip, draw: (place: Place) => Point, to: Point): number {
  const { length = 0, closed = false, along = 0 } = grip.curve ?? {};
  const drawn = placesOf(grip).map(draw);
  const step = length / (drawn.length - 1);
  const ways = drawn.slice(1).map((end, k) => {
    const begin = drawn[k] ?? end;
    const share = nearest(begin, end, to);
    const [x, y] = [begin[0] + share * (end[0] - begin[0]), begin[1] + share * (end[1] - begin[1])];
    const by = (k + share) * step - along;
    return { by: closed ? by - length * Math.round(by / length) : by, far: Math.hypot(x - to[0], y - to[1]) };
  });
  const spans = [0, 1]
    .map((axis) => drawn.map((place) => place[axis as 0 | 1]))
    .map((each) => Math.max(...each) - Math.min(...each));
  // Of parts of the curve that cross in the picture it is the one that the point is on.
  const dear = (NEARER * Math.max(...spans)) / length;
  const cost = ({ by, far }: { by: number; far: number }): number => far + dear * Math.abs(by);
  return ways.reduce((best, each) => (cost(each) < cost(best) ? each : best), { by: 0, far: Infinity }).by;
}

/** Whether the curve is seen from above as more than a line straight up. */
export function isSeenFromAbove(grip: JointGrip, flat: number): boolean {
  const places = placesOf(grip);
  const [x, y] = [0, 1]
    .map((axis) => places.map((place) => place[axis as 0 | 1]))
    .map((each) => Math.max(...each) - Math.min(...each));
  return Math.max(x ?? 0, y ?? 0) > flat * (grip.curve?.length ?? 1);
}

function placesOf({ curve }: JointGrip): Place[] {
  const { points = [] } = curve ?? {};
  return Array.from(
    { length: points.length / 3 },
    (_, k): Place => [points[3 * k] ?? 0, points[3 * k + 1] ?? 0, points[3 * k + 2] ?? 0],
  );
}

/** Where the point is on the curve once it has gone so far, 0 to 1. */
function shareOf({ curve }: JointGrip, by: number): number {
  const share = ((curve?.along ?? 0) + by) / (curve?.length ?? 1);
  return curve?.closed ? share - Math.floor(share) : Math.min(Math.max(share, 0), 1);
}

/** Where a segment is nearest to a point, 0 at its begin. */
function nearest([x, y]: Point, [u, v]: Point, [p, q]: Point): number {
  const size = (u - x) ** 2 + (v - y) ** 2;
  return size ? Math.min(Math.max(((p - x) * (u - x) + (q - y) * (v - y)) / size, 0), 1) : 0;
}
