/** Points and angles of the plane, in metres and degrees. */

import type { Bounds, Item, Point } from "../api";

export const add = (a: Point, b: Point): Point => [a[0] + b[0], a[1] + b[1]];
export const minus = (a: Point, b: Point): Point => [a[0] - b[0], a[1] - b[1]];
export const times = (a: Point, factor: number): Point => [a[0] * factor, a[1] * factor];
export const dot = (a: Point, b: Point): number => a[0] * b[0] + a[1] * b[1];
export const length = (a: Point): number => Math.hypot(a[0], a[1]);
export const distance = (a: Point, b: Point): number => Math.hypot(a[0] - b[0], a[1] - b[1]);
export const middle = (a: Point, b: Point): Point => [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];

/** The unit vector of a heading, counter-clockwise from x. */
export function direction(degrees: number): Point {
  const angle = (degrees * Math.PI) / 180;
  return [Math.cos(angle), Math.sin(angle)];
}

/** Heading of a vector, in (-180, 180]. */
export function heading(vector: Point): number {
  // Adding 0 turns -0 into 0: atan2(-0, -1) is -180 degrees.
  return (Math.atan2(vector[1] + 0, vector[0]) * 180) / Math.PI;
}

/** The same angle in (-180, 180]. */
export function turned(degrees: number): number {
  const angle = ((degrees % 360) + 360) % 360;
  return angle > 180 ? angle - 360 : angle;
}

export function rotate(vector: Point, degrees: number): Point {
  const [c, s] = direction(degrees);
  return [c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]];
}

/** The point of a segment nearest to a point, and how far along it lies (0 to 1). */
export function nearestOn(point: Point, a: Point, b: Point): { at: Point; along: number } {
  const way = minus(b, a);
  const square = dot(way, way);
  const along = square === 0 ? 0 : Math.min(Math.max(dot(minus(point, a), way) / square, 0), 1);
  return { at: add(a, times(way, along)), along };
}

export function inside(point: Point, polygon: Point[]): boolean {
  let odd = false;
  polygon.forEach((a, index) => {
    const b = polygon[(index + 1) % polygon.length] ?? a;
    const crosses = a[1] > point[1] !== b[1] > point[1];
    if (crosses && point[0] < a[0] + ((point[1] - a[1]) / (b[1] - a[1])) * (b[0] - a[0])) odd = !odd;
  });
  return odd;
}

/** How far a point is from a polygon; 0 inside. */
export function distanceTo(point: Point, polygon: Point[]): number {
  if (polygon.length > 2 && inside(point, polygon)) return 0;
  const edges = polygon.map((a, index) => nearestOn(point, a, polygon[(index + 1) % polygon.length] ?? a).at);
  return Math.min(Infinity, ...edges.map((at) => distance(point, at)));
}

export function boundsOf(points: Point[]): Bounds {
  const [xs, ys] = [points.map((point) => point[0]), points.map((point) => point[1])];
  return [Math.min(...xs), Math.min(...ys), Math.max(...xs), Math.max(...ys)];
}

export function overlaps(a: Bounds, b: Bounds): boolean {
  return a[0] <= b[2] && b[0] <= a[2] && a[1] <= b[3] && b[1] <= a[3];
}

/** A point as it is written in the text. */
export const rounded = ([x, y]: Point): Point => [short(x), short(y)];

/** A number as it is written: at most so many decimals, no zeros behind. */
export function short(value: number, decimals = 4): number {
  return Number(value.toFixed(decimals)) + 0;
}

/** Whether an opening of a wall is a window: a doorway begins at the floor. */
export function isWindow({ kind, values }: Item): boolean {
  return kind === "opening" && Number(values["sill"] ?? 0) > 0;
}
