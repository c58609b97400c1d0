/** What a drag makes of an item: its look meanwhile, and which numbers of the text change. Nothing is drawn here. */

import type { Change, Item, Point } from "../api";
import {
  add,
  direction,
  distance,
  dot,
  heading,
  length,
  middle,
  minus,
  nearestOn,
  rotate,
  rounded,
  short,
  times,
  turned,
} from "../plan/geometry";

/** An item as it would be, and the changes of the text that make it so. */
export interface Changed {
  ghost: Item;
  changes: Change[];
}

/** Keys of obstacles and patches whose first two numbers are length and width. */
const SIZES = ["box", "ramp", "steps", "size"] as const;
/** Nothing is made smaller than this [m]. */
const LEAST = 0.02;

export const isPoint = (value: unknown): value is Point =>
  Array.isArray(value) && value.length >= 2 && typeof value[0] === "number" && typeof value[1] === "number";

/** Corners of a wall's centreline, world frame. */
export function cornersOf(item: Item): Point[] {
  const points = item.values["points"];
  return Array.isArray(points) ? points.filter(isPoint).map(([x, y]) => [x, y]) : [];
}

export function isWall(item: Item): boolean {
  return item.type === "Wall";
}

/** Ends of a wall's segments; the closing one is the last. */
export function segmentsOf(wall: Item): [Point, Point][] {
  const corners = cornersOf(wall);
  const ends = wall.values["closed"] === true ? corners : corners.slice(0, -1);
  return ends.map((corner, index) => [corner, corners[(index + 1) % corners.length] ?? corner]);
}

/** Whether it is a joint of a mechanism, drawn as the body that it moves. */
export function isJoint(item: Item): boolean {
  return item.kind === "joint";
}

/** Whether it is a person who sits: where and how, the seat says. */
export function isSeated(item: Item): boolean {
  return item.type === "Person" && typeof item.values["seat"] === "string";
}

/** Whether it has a heading of its own that can be turned. */
export function canTurn(item: Item): boolean {
  return isWall(item) || ("heading_deg" in item.values && !isSeated(item));
}

/** Shift an item; an opening slides along its wall instead. */
export function moved(item: Item, by: Point, items: Item[]): Changed {
  if (isWall(item))
    return reshaped(
      item,
      cornersOf(item).map((corner) => rounded(add(corner, by))),
    );
  if (item.type === "Opening") return slid(item, by, items);
  // A joint is moved by the pose of its mechanism.
  if (isJoint(item) || isSeated(item)) return { ghost: item, changes: [] };
  const at = item.values["at"];
  const place = isPoint(at) ? at : (item.at ?? [0, 0]);
  const own = rotate(by, -frameOf(item, items));
  const to = rounded(add([place[0], place[1]], own));
  const value = isPoint(at) ? [...to, ...at.slice(2)] : to;
  const ghost = shifted(item, rotate(minus(to, [place[0], place[1]]), frameOf(item, items)));
  ghost.values = { ...item.values, at: value };
  return { ghost, changes: [{ op: "set", path: [...item.path, "at"], value }] };
}

/** Turn an item about its middle by degrees. */
export function spun(item: Item, degrees: number): Changed {
  if (isWall(item)) {
    const corners = cornersOf(item);
    const pivot = pivotOf(item);
    return reshaped(
      item,
      corners.map((corner) => rounded(add(pivot, rotate(minus(corner, pivot), degrees)))),
    );
  }
  const from = typeof item.values["heading_deg"] === "number" ? item.values["heading_deg"] : 0;
  const value = short(turned(from + degrees), 2);
  const pivot = item.at ?? [0, 0];
  const by = value - from;
  const turn = (point: Point): Point => add(pivot, rotate(minus(point, pivot), by));
  const ghost = {
    ...item,
    polygons: item.polygons.map((polygon) => polygon.map(turn)),
    values: { ...item.values, heading_deg: value },
  };
  ghost.heading_deg = (item.heading_deg ?? 0) + by;
  return { ghost, changes: [{ op: "set", path: [...item.path, "heading_deg"], value }] };
}

/** About which point it turns. */
export function pivotOf(item: Item): Point {
  if (!isWall(item)) return item.at ?? [0, 0];
  const corners = cornersOf(item);
  const sum = corners.reduce((total, corner) => add(total, corner), [0, 0]);
  return times(sum, 1 / Math.max(corners.length, 1));
}

/** A wall with one corner elsewhere. */
export function withCorner(item: Item, index: number, to: Point): Changed {
  return reshaped(
    item,
    cornersOf(item).map((corner, k) => (k === index ? rounded(to) : corner)),
  );
}

/** Handles by which an item's size is drawn: each has a place, and what the item is when it is drawn elsewhere. */
export interface Handle {
  at: Point;
  cursor: string;
  /** Which corner of a wall it is. */
  corner?: number;
  /** It makes a new corner. */
  fresh?: boolean;
  drawn(to: Point): Changed;
}

export function handlesOf(item: Item, items: Item[]): Handle[] {
  if (item.fixed) return [];
  if (isWall(item)) return [...cornerHandles(item), ...newCorners(item)];
  if (item.type === "Opening") return openingHandles(item, items);
  if (item.type === "Beacon") return beaconHandles(item);
  const key = SIZES.find((size) => Array.isArray(item.values[size]));
  if (key) return boxHandles(item, key, items);
  return Array.isArray(item.values["cylinder"]) || typeof item.values["sphere"] === "number" ? roundHandles(item) : [];
}

function cornerHandles(item: Item): Handle[] {
  return cornersOf(item).map((at, corner) => ({
    at,
    corner,
    cursor: "move",
    drawn: (to) => withCorner(item, corner, to),
  }));
}

/** In the middle of each segment: drawn elsewhere it becomes a corner. A wall with openings keeps its segments. */
function newCorners(item: Item): Handle[] {
  const openings = item.values["openings"];
  if (Array.isArray(openings) && openings.length) return [];
  return segmentsOf(item).map(([from, to], segment) => {
    const drawn = (place: Point): Changed => {
      const value = rounded(place);
      const old = cornersOf(item);
      const corners = [...old.slice(0, segment + 1), value, ...old.slice(segment + 1)];
      const last = segment + 1 === corners.length - 1;
      const path = [...item.path, "points", ...(last ? [] : [segment + 1])];
      return { ghost: reshaped(item, corners).ghost, changes: [{ op: "add", path, value }] };
    };
    return { at: middle(from, to), cursor: "copy", corner: segment + 1, fresh: true, drawn };
  });
}

function boxHandles(item: Item, key: string, items: Item[]): Handle[] {
  const [size, at, turn] = [item.values[key] as number[], item.at, item.heading_deg ?? 0];
  const [long, wide] = [size[0] ?? 1, size[1] ?? 1];
  if (!at) return [];
  const sides: Point[] = [
    [1, 1],
    [-1, 1],
    [-1, -1],
    [1, -1],
    [1, 0],
    [0, 1],
    [-1, 0],
    [0, -1],
  ];
  return sides.map((side) => {
    const reach: Point = [(side[0] * long) / 2, (side[1] * wide) / 2];
    const drawn = (to: Point): Changed => {
      const far = minus([0, 0], reach); // the side across stays where it is
      const local = rotate(minus(to, at), -turn);
      const fresh = [0, 1].map((axis) => {
        const along = (local[axis] ?? 0) - (far[axis] ?? 0);
        return side[axis] ? Math.max(short(along * (side[axis] ?? 0)), LEAST) : (size[axis] ?? 0);
      });
      const grown: Point = [(((fresh[0] ?? 0) - long) / 2) * side[0], (((fresh[1] ?? 0) - wide) / 2) * side[1]];
      const shift = moved(item, rotate(grown, turn), items);
      const value = [...fresh, ...size.slice(2)];
      const ghost = {
        ...shift.ghost,
        polygons: [rectangle(shift.ghost.at ?? at, turn, fresh[0] ?? long, fresh[1] ?? wide)],
      };
      ghost.values = { ...shift.ghost.values, [key]: value };
      return { ghost, changes: [{ op: "set", path: [...item.path, key], value }, ...shift.changes] };
    };
    return { at: add(at, rotate(reach, turn)), cursor: cursorAlong(heading(rotate(reach, turn))), drawn };
  });
}

function roundHandles(item: Item): Handle[] {
  const { at } = item;
  if (!at) return [];
  const size = item.values["cylinder"];
  const radius = Array.isArray(size) ? Number(size[0]) : Number(item.values["sphere"]);
  return [45, 225].map((angle) => ({
    at: add(at, times(direction(angle), radius)),
    cursor: cursorAlong(angle),
    drawn: (to: Point) => {
      const value = Math.max(short(distance(to, at), 2), LEAST);
      const grow = (point: Point): Point => add(at, times(minus(point, at), value / radius));
      const key = Array.isArray(size) ? "cylinder" : "sphere";
      const whole = Array.isArray(size) ? [value, ...size.slice(1)] : value;
      const ghost = {
        ...item,
        polygons: item.polygons.map((polygon) => polygon.map(grow)),
        values: { ...item.values, [key]: whole },
      };
      return { ghost, changes: [{ op: "set", path: [...item.path, key], value: whole }] };
    },
  }));
}

function beaconHandles(item: Item): Handle[] {
  const { at } = item;
  const width = item.values["width"];
  if (!at || typeof width !== "number" || (!item.values["image"] && !item.values["marker"])) return [];
  const across = direction((item.heading_deg ?? 0) + 90);
  return [1, -1].map((side) => ({
    at: add(at, times(across, (side * width) / 2)),
    cursor: cursorAlong(heading(across)),
    drawn: (to: Point) => {
      const value = Math.max(short(2 * Math.abs(dot(minus(to, at), across)), 2), LEAST);
      const stretch = (point: Point): Point =>
        add(point, times(across, dot(minus(point, at), across) * (value / width - 1)));
      const ghost = {
        ...item,
        polygons: item.polygons.map((polygon) => polygon.map(stretch)),
        values: { ...item.values, width: value },
      };
      return { ghost, changes: [{ op: "set", path: [...item.path, "width"], value }] };
    },
  }));
}

function openingHandles(item: Item, items: Item[]): Handle[] {
  const frame = openingFrame(item, items);
  if (!frame) return [];
  const { start, along, at, width, long } = frame;
  const place = (far: number): Point => add(start, times(along, far));
  const drawn = (to: Point, first: boolean): Changed => {
    const wish = Math.min(Math.max(dot(minus(to, start), along), 0), long);
    const far = Math.min(short(wish, 2), long); // rounding must not exceed the length of the wall
    const from = first ? Math.min(far, at + width - LEAST) : at;
    const wide = short(first ? at + width - from : Math.max(far - at, LEAST));
    const changes: Change[] = [{ op: "set", path: [...item.path, "width"], value: wide }];
    if (first) changes.push({ op: "set", path: [...item.path, "at"], value: from });
    return { ghost: openingGhost(item, frame, from, wide), changes };
  };
  return [true, false].map((first) => ({
    at: place(first ? at : at + width),
    cursor: cursorAlong(heading(along)),
    drawn: (to: Point) => drawn(to, first),
  }));
}

interface OpeningFrame {
  start: Point;
  along: Point;
  long: number;
  at: number;
  width: number;
  thickness: number;
}

function openingFrame(item: Item, items: Item[]): OpeningFrame | null {
  const wall = items.find(
    (other) => isWall(other) && JSON.stringify(other.path) === JSON.stringify(item.path.slice(0, -2)),
  );
  const ends = wall && segmentsOf(wall)[Number(item.values["segment"] ?? 0)];
  const [at, width] = [item.values["at"], item.values["width"]];
  if (!wall || !ends || typeof at !== "number" || typeof width !== "number") return null;
  const long = distance(...ends);
  const along = times(minus(ends[1], ends[0]), 1 / Math.max(long, 1e-9));
  return { start: ends[0], along, long, at, width, thickness: Number(wall.values["thickness"] ?? 0.1) };
}

function slid(item: Item, by: Point, items: Item[]): Changed {
  const frame = openingFrame(item, items);
  if (!frame) return { ghost: item, changes: [] };
  const far = frame.at + dot(by, frame.along);
  const value = short(Math.min(Math.max(far, 0), Math.max(frame.long - frame.width, 0)), 3);
  const ghost = openingGhost(item, frame, value, frame.width);
  return { ghost, changes: [{ op: "set", path: [...item.path, "at"], value }] };
}

function openingGhost(item: Item, frame: OpeningFrame, at: number, width: number): Item {
  const centre = add(frame.start, times(frame.along, at + width / 2));
  const polygons = [rectangle(centre, heading(frame.along), width, frame.thickness)];
  return { ...item, at: centre, polygons, values: { ...item.values, at, width } };
}

/** A wall through other corners; only those that differ are written. */
function reshaped(item: Item, corners: Point[]): Changed {
  const before = cornersOf(item);
  const changes: Change[] = [];
  corners.forEach((value, index) => {
    const old = before[index];
    if (!old || old[0] !== value[0] || old[1] !== value[1])
      changes.push({ op: "set", path: [...item.path, "points", index], value });
  });
  const ghost = { ...item, values: { ...item.values, points: corners } };
  ghost.polygons = wallOutlines(corners, item.values["closed"] === true, Number(item.values["thickness"] ?? 0.1));
  return { ghost, changes };
}

/** Outlines of a wall's segments, joined by squares at the corners. */
export function wallOutlines(corners: Point[], closed: boolean, thickness: number): Point[][] {
  const last = closed ? corners.length : corners.length - 1;
  return corners.slice(0, last).flatMap((from, index) => {
    const to = corners[(index + 1) % corners.length] ?? from;
    const long = distance(from, to);
    return long < 1e-9
      ? []
      : [rectangle(middle(from, to), heading(minus(to, from)), long + (corners.length > 2 ? thickness : 0), thickness)];
  });
}

export function rectangle(centre: Point, turn: number, long: number, wide: number): Point[] {
  const corners: Point[] = [
    [long / 2, wide / 2],
    [-long / 2, wide / 2],
    [-long / 2, -wide / 2],
    [long / 2, -wide / 2],
  ];
  return corners.map((corner) => add(centre, rotate(corner, turn)));
}

function shifted(item: Item, by: Point): Item {
  const polygons = item.polygons.map((polygon) => polygon.map((point) => add(point, by)));
  return { ...item, polygons, at: item.at ? add(item.at, by) : null };
}

/** Heading of the frame that an item's `at` is written in: that of what it hangs on, else the world's. */
function frameOf(item: Item, items: Item[]): number {
  const on = item.values["on"];
  return (typeof on === "string" && items.find((other) => other.name === on)?.heading_deg) || 0;
}

function cursorAlong(degrees: number): string {
  const names = ["ew-resize", "nesw-resize", "ns-resize", "nwse-resize"];
  return names[Math.round((((degrees % 180) + 180) % 180) / 45) % 4] ?? "move";
}

/** The place on the face of a wall that is nearest to a point: where something hangs there, and where it then looks. */
export function faceNear(point: Point, walls: Item[], reach: number): { at: Point; heading_deg: number } | null {
  let best: { at: Point; heading_deg: number; far: number } | null = null;
  for (const wall of walls) {
    const half = Number(wall.values["thickness"] ?? 0.1) / 2;
    for (const [from, to] of segmentsOf(wall)) {
      const { at, along } = nearestOn(point, from, to);
      const far = distance(point, at);
      if (far > reach || (best && far >= best.far) || along <= 0 || along >= 1) continue;
      const normal = normalToward(point, at, from, to);
      best = { at: add(at, times(normal, half + 0.01)), heading_deg: short(heading(normal), 2), far };
    }
  }
  return best;
}

function normalToward(point: Point, at: Point, from: Point, to: Point): Point {
  const way = minus(to, from);
  const long = Math.max(length(way), 1e-9);
  const left: Point = [-way[1] / long, way[0] / long];
  return dot(minus(point, at), left) >= 0 ? left : times(left, -1);
}
