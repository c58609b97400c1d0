/** Where a point goes that was meant to be near something: ends of walls, right angles, the grid. */

import type { Item, Point } from "../api";
import { add, direction, distance, dot, heading, minus, nearestOn, rounded, short, times } from "../plan/geometry";
import { cornersOf, isWall, segmentsOf } from "./shapes";

export interface Snapped {
  at: Point;
  /** What it was drawn to; its name is shown. */
  to: "end" | "wall" | "angle" | "grid" | null;
}

export interface Snapping {
  /** Step of the grid [m]. */
  step: number;
  /** How near is near [m]. */
  reach: number;
  walls: Item[];
  /** Corners of the wall that is being drawn, the last one first to be turned from. */
  from?: Point[];
}

/** Draw a point of a wall to the end of another, else to a right angle with the last corner, else to the grid. */
export function snapCorner(point: Point, { step, reach, walls, from = [] }: Snapping): Snapped {
  const ends = [...walls.filter(isWall).flatMap(cornersOf), ...from];
  const end = nearest(point, ends, reach);
  if (end) return { at: end, to: "end" };
  const last = from[from.length - 1];
  if (last) {
    const angled = snapAngle(point, last, from[from.length - 2], step);
    if (angled) return onWall(angled, walls, reach) ?? { at: angled, to: "angle" };
  }
  return onWall(point, walls, reach / 2) ?? { at: toGrid(point, step), to: "grid" };
}

export function toGrid([x, y]: Point, step: number): Point {
  return [short(Math.round(x / step) * step), short(Math.round(y / step) * step)];
}

/** The direction from the last corner drawn to the axes and to what is square to the last segment, within 6 degrees. */
function snapAngle(point: Point, last: Point, before: Point | undefined, step: number): Point | null {
  const way = minus(point, last);
  const base = before ? heading(minus(last, before)) : 0;
  const angles = [0, 90, 180, -90, base, base + 90, base - 90, 45, 135, -45, -135];
  const far = Math.hypot(...way);
  const angle = angles.find((value) => Math.abs(turnBetween(heading(way), value)) < 6);
  if (angle === undefined || far < step / 2) return null;
  const ahead = direction(angle);
  const along = Math.round(dot(way, ahead) / step) * step;
  return rounded(add(last, times(ahead, along)));
}

/** Snap to the nearest wall centreline within reach, so that walls can be joined. */
function onWall(point: Point, walls: Item[], reach: number): Snapped | null {
  const feet = walls
    .filter(isWall)
    .flatMap(segmentsOf)
    .map(([from, to]) => nearestOn(point, from, to).at);
  const foot = nearest(point, feet, reach);
  return foot && { at: rounded(foot), to: "wall" };
}

function nearest(point: Point, among: Point[], reach: number): Point | null {
  const near = among.filter((other) => distance(other, point) <= reach);
  return near.sort((a, b) => distance(a, point) - distance(b, point))[0] ?? null;
}

function turnBetween(a: number, b: number): number {
  return ((((a - b) % 360) + 540) % 360) - 180;
}
