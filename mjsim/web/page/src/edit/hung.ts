/** Pictures go with the wall on which they hang, when it is moved, turned or reshaped. Nothing is drawn here. */

import type { Change, Item, Path, Point } from "../api";
import { add, direction, dot, heading, length, minus, times, turned } from "../plan/geometry";
import { keyOf } from "../plan/plan";
import { type Changed, isWall, moved, segmentsOf, spun } from "./shapes";

/** A picture hangs on a wall when it is so near to its face [m], */
const NEAR = 0.06;
/** and looks so straight away from it [deg]. */
const ASKEW = 10;

/** Of walls that do not say how thick they are [m]. */
const THICKNESS = 0.1;

type Segment = [Point, Point];

/** What is changed, with the pictures that go along; those that are changed themselves do not. */
export function withPictures(changed: Changed[], items: Item[]): Changed[] {
  const keys = new Set(changed.map(({ ghost }) => keyOf(ghost.path)));
  const walls = changed.map(({ ghost }) => ghost).filter(isWall);
  if (!walls.length) return changed;
  const pictures = items.filter((item) => isFree(item) && !keys.has(keyOf(item.path)));
  const before = new Map(items.filter(isWall).map((wall) => [keyOf(wall.path), wall]));
  const along = (picture: Item): Changed[] =>
    walls.flatMap((wall) => followed(picture, before.get(keyOf(wall.path)), wall, items)).slice(0, 1);
  return [...changed, ...pictures.flatMap(along)];
}

/** What goes with a value that is set in a wall, at a path from there on: pictures go with its corners and its faces. */
export function picturesAlong(wall: Item, [key, ...deeper]: Path, value: unknown, items: Item[]): Change[] {
  if (!isWall(wall) || (key !== "points" && key !== "thickness")) return [];
  const ghost = { ...wall, values: { ...wall.values, [key]: put(wall.values[key], deeper, value) } };
  return withPictures([{ ghost, changes: [] }], items)
    .slice(1)
    .flatMap(({ changes }) => changes);
}

/** A value with another one at a path in its lists. */
function put(value: unknown, [key, ...deeper]: Path, fresh: unknown): unknown {
  if (key === undefined) return fresh;
  return Array.isArray(value) ? value.map((each, k): unknown => (k === key ? put(each, deeper, fresh) : each)) : value;
}

function isFree(item: Item): boolean {
  return item.type === "Beacon" && !item.fixed && item.at !== null && typeof item.values["on"] !== "string";
}

/** The picture where the wall takes it; nothing where it does not hang on the wall. */
function followed(picture: Item, before: Item | undefined, after: Item, items: Item[]): Changed[] {
  const [old, fresh] = [before ? segmentsOf(before) : [], segmentsOf(after)];
  const half = before ? halfOf(before) : 0;
  const index = old.findIndex((segment) => hangsOn(picture, segment, half + NEAR));
  const [from, to, out] = [old[index], fresh[index], halfOf(after) - half];
  if (!from || !to || Number.isNaN(out) || !picture.at || old.length !== fresh.length || length(minus(...to)) === 0)
    return [];
  const turn = turned(heading(minus(to[1], to[0])) - heading(minus(from[1], from[0])));
  const put = spun(picture, Math.abs(turn) > 0.005 ? turn : 0);
  const place = moved(put.ghost, minus(carried(picture.at, from, to, out), picture.at), items);
  const own = [...place.changes, ...(Math.abs(turn) > 0.005 ? put.changes : [])];
  return [{ ghost: place.ghost, changes: own }];
}

function hangsOn({ at, heading_deg }: Item, [start, end]: Segment, reach: number): boolean {
  if (!at || heading_deg === null) return false;
  const [along, off] = within(at, [start, end]);
  const away = direction(heading_deg);
  const straight = dot(away, sideOf([start, end])) * Math.sign(off);
  return (
    along >= 0 &&
    along <= length(minus(end, start)) &&
    Math.abs(off) <= reach &&
    straight > Math.cos((ASKEW * Math.PI) / 180)
  );
}

/** From the middle of a wall to its faces [m]. */
function halfOf(wall: Item): number {
  return Number(wall.values["thickness"] ?? THICKNESS) / 2;
}

/**
 * Where a point of a segment lies once that is elsewhere: as far from the end that stayed, else from the start, and
 * farther out by so much as the wall has grown there.
 */
function carried(at: Point, from: Segment, to: Segment, out: number): Point {
  const [along, off] = within(at, from);
  const [was, long] = [length(minus(from[1], from[0])), length(minus(to[1], to[0]))];
  const isEndKept = length(minus(from[1], to[1])) === 0;
  const now = Math.min(Math.max(isEndKept ? long - (was - along) : along, 0), long);
  const way = times(minus(to[1], to[0]), 1 / long);
  return add(add(to[0], times(way, now)), times(sideOf(to), off + Math.sign(off) * out));
}

/** How far along a segment a point lies from its start, and how far to its left [m]. */
function within(at: Point, [start, end]: Segment): [number, number] {
  const [way, to] = [minus(end, start), minus(at, start)];
  return [dot(to, way) / length(way), dot(to, sideOf([start, end]))];
}

/** The direction to the left of a segment. */
function sideOf([start, end]: Segment): Point {
  const [x, y] = minus(end, start);
  return times([-y, x], 1 / Math.hypot(x, y));
}
