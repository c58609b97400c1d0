/** Where the shapes of items lie on the screen, and their colours: those of all pictures. */

import type { Item, Point } from "../api";
import type { PlanShape } from "../run/protocol";
import type { Tokens } from "../ui/ink";
import { add, minus, rotate, times } from "./geometry";
import { type Mix, ROLES, type Style } from "./roles";
import type { PlanView } from "./view";

/** A millimetre on paper [px]. */
export const MM = 5;

/** Where something stands when it is not where its Item says. */
export interface Stand {
  at: Point;
  heading_deg: number;
  /** Its outlines, where they are others than there, world frame [m]. */
  polygons?: Point[][];
}

/** How an item is shown. */
export interface Look {
  selected?: boolean;
  hovered?: boolean;
  problem?: "error" | "warning" | null;
  /** That it is no item of the text itself: it is hatched. */
  origin?: Item["origin"];
  /** That it is not there now. */
  gone?: boolean;
}

/** Outlines of an item where it stands, world frame [m]. */
export function outlines(item: Item, stand?: Stand): Point[][] {
  return stand && item.at ? filled(item, stand).flat() : item.polygons;
}

/** The outlines that each shape of an item fills, where it stands; the last area fills all that are left. */
export function filled(item: Item, stand?: Stand): Point[][][] {
  const polygons = stand?.polygons ?? item.polygons;
  const last = item.shapes.findLastIndex(({ count }) => count !== undefined);
  let next = 0;
  return item.shapes.map((shape, k) => {
    if (shape.count === undefined) return [];
    const own = polygons.slice(next, k === last ? undefined : next + shape.count); // a drag may change their number
    next += shape.count;
    return stand?.polygons ? own : own.map((polygon) => polygon.map((at) => carried(item, shape, at, stand)));
  });
}

/** Where a point of a shape is now, world frame [m]. */
function carried(item: Item, shape: PlanShape, at: Point, stand?: Stand): Point {
  if (!stand || !item.at || shape.fixed) return at;
  const [x, y] = shape.carrier ?? item.at;
  return add(stand.at, rotate(minus(at, [x, y]), turnOf(item, shape, stand)));
}

/** By how much a shape has turned [deg]. */
function turnOf(item: Item, shape: PlanShape, stand?: Stand): number {
  return stand && !shape.fixed ? stand.heading_deg - (shape.carrier?.[2] ?? item.heading_deg ?? 0) : 0;
}

/** The lines and symbols of a shape in pixels, as `PlanItem.placed` has them. */
export function placed(item: Item, shape: PlanShape, view: PlanView, stand?: Stand): Point[][] {
  const [x, y, own] = shape.anchor ?? [0, 0, 0];
  const heading = item.heading_deg ?? 0;
  const world = (at: Point): Point => carried(item, shape, add(item.at ?? [0, 0], rotate(at, heading)), stand);
  if (!shape.anchor) return (shape.parts ?? []).map((part) => part.map((at) => view.toScreen(world(at))));
  const turn = heading + own + turnOf(item, shape, stand);
  const anchor = view.toScreen(world([x, y]));
  return (shape.parts ?? []).map((part) =>
    part.map((at) => {
      const [right, up] = rotate(times(at, MM), turn);
      return add(anchor, [right, -up]);
    }),
  );
}

export interface Ink {
  fill: string | null;
  line: string | null;
  /** [px] */
  width: number;
  dash: number;
}

/** The colours of a shape; what is selected has its lines in those of the selection. */
export function inkOf(shape: PlanShape, closed: boolean, palette: Tokens, look: Look): Ink {
  const style: Style = ROLES[shape.role] ?? { width: 0 };
  const isPlain = String(style.fill) === String(style.line);
  const fill =
    !closed || !style.fill ? null : blend(palette.ground, mixed(style.fill, shape, palette), shape.level ?? 1);
  const line = style.line && !(closed && shape.anchor && isPlain) ? mixed(style.line, shape, palette) : null;
  const width = Math.max(style.width * MM, look.selected ? 2 : 1);
  return {
    fill: look.selected && isPlain && fill ? palette.accent : fill,
    line: look.selected && line ? palette.accent : line,
    width,
    dash: (style.dash ?? 0) * MM,
  };
}

function mixed([one, other, share]: Mix, { tint }: PlanShape, palette: Tokens): string {
  const hex = (ink: Mix[0]): string =>
    ink === "tint" ? (tint ?? palette.muted) : ink === "paper" ? palette.ground : palette[ink];
  return blend(hex(one), hex(other), share);
}

/** A colour '#rrggbb' mixed with a share of another, '#rrggbb'. */
function blend(one: string, other: string, share: number): string {
  const [a, b] = [channels(one), channels(other)];
  const mixed = a.map((value, index) => Math.round((1 - share) * value + share * (b[index] ?? value)));
  return `#${mixed.map((value) => value.toString(16).padStart(2, "0")).join("")}`;
}

function channels(text: string): number[] {
  return [1, 3, 5].map((start) => Number.parseInt(text.slice(start, start + 2), 16) || 0);
}
