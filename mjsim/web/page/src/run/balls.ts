/** Ball joints that a hand moves: which rotation brings the handle of one to a place of a picture. */

import type { Point } from "../api";
import type { Place } from "../scene/grip";
import type { JointGrip, JointRow } from "./protocol";
import { aside, between, crossed, minus, ofVector, plus, product, rotated, times, toVector } from "./rotations";

/** Steps of the search, and how far it tilts the handle for a slope [rad]. */
const STEPS = 8;
const SLOPE = 1e-4;
/** Directions that are as near to the pointer, relative to the handle's size in the picture, count as equal. */
const EQUAL = 0.01;
const SIDES = [-1, 0, 1];

/** The rotation vector of a ball joint now, if it is known [rad]. */
export function rotationOf({ of, joint }: JointGrip, rows: Record<string, Record<string, JointRow>>): Place | null {
  const [x, y, z] = ["rx", "ry", "rz"].map((value) => rows[of]?.[`${joint}.${value}`]?.[0] ?? null);
  return x == null || y == null || z == null ? null : [x, y, z];
}

/** Where the handle is after the body was rotated in the world by a rotation vector. */
export function ballAfter({ at, grip }: JointGrip, by: Place): Place {
  return plus(at, rotated(minus(grip, at), by));
}

/** The rotation vector of the joint after the body was rotated in the world. */
export function rotationAfter({ ball }: JointGrip, rotation: Place, by: Place): Place {
  if (!ball) return rotation;
  const [a = 1, b = 0, c = 0, d = 0, e = 1, f = 0, g = 0, h = 0, i = 1] = ball.axes;
  const own: Place = [
    a * by[0] + b * by[1] + c * by[2],
    d * by[0] + e * by[1] + f * by[2],
    g * by[0] + h * by[1] + i * by[2],
  ];
  const turned = product(ofVector(own), ofVector(times(rotation, ball.way)));
  return times(toVector(turned), ball.way);
}

/** One rotation in the world after another, as a rotation vector. */
export function both(first: Place, second: Place): Place {
  return toVector(product(ofVector(second), ofVector(first)));
}

/**
 * The rotation in the world that takes the handle as near as it can be to a place of a picture.
 *
 * Two directions may be as near, towards who looks and away: it is the one that turns the body less.
 */
export function ballTo(grip: JointGrip, draw: (place: Place) => Point, to: Point): Place {
  const lever = minus(grip.grip, grip.at);
  const size = Math.hypot(...lever);
  const missed = (way: Place): Point => {
    const [x, y] = draw(plus(grip.at, way));
    return [x - to[0], y - to[1]];
  };
  const far = (way: Place): number => Math.hypot(...missed(way));
  const ways = [lever, ...directions().map((way) => times(way, size / Math.hypot(...way)))].map((way) =>
    nearest(way, missed),
  );
  const [x, y] = draw(grip.at);
  const reach = Math.max(
    ...ways.map((way) => Math.hypot(draw(plus(grip.at, way))[0] - x, draw(plus(grip.at, way))[1] - y)),
  );
  const limit = Math.min(...ways.map(far)) + EQUAL * reach;
  const turns = ways.filter((way) => far(way) <= limit).map((way) => between(lever, way));
  return turns.reduce((best, each) => (Math.hypot(...each) < Math.hypot(...best) ? each : best));
}

function directions(): Place[] {
  return SIDES.flatMap((x) => SIDES.flatMap((y) => SIDES.map((z): Place => [x, y, z]))).filter(
    (way) => Math.hypot(...way) > 0,
  );
}

/** Tilt a direction until what is missed grows no less, by the method of Gauss and Newton. */
function nearest(way: Place, missed: (way: Place) => Point): Place {
  for (let step = 0; step < STEPS; step++) {
    const first = aside(way);
    const axes = [first, times(crossed(way, first), 1 / Math.hypot(...way))] as const;
    const [x, y] = missed(way);
    const [u, v] = axes.map((axis) => {
      const [right, down] = missed(rotated(way, times(axis, SLOPE)));
      return [(right - x) / SLOPE, (down - y) / SLOPE] as const;
    }) as [Point, Point];
    // Damped, because a handle that points at who looks is seen to move in no direction but two.
    const [a, b, c] = [u[0] ** 2 + u[1] ** 2, u[0] * v[0] + u[1] * v[1], v[0] ** 2 + v[1] ** 2];
    const damping = 1e-6 * (a + c) + 1e-12;
    const [p, q] = [-(u[0] * x + u[1] * y), -(v[0] * x + v[1] * y)];
    const determinant = (a + damping) * (c + damping) - b * b;
    const tilt = plus(
      times(axes[0], ((c + damping) * p - b * q) / determinant),
      times(axes[1], ((a + damping) * q - b * p) / determinant),
    );
    const angle = Math.hypot(...tilt);
    const next = rotated(way, angle > 0.5 ? times(tilt, 0.5 / angle) : tilt);
    if (Math.hypot(...missed(next)) >= Math.hypot(x, y)) break;
    way = next;
  }
  return way;
}
