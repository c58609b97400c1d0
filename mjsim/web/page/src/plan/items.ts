/** Drawing of walls, things, beacons and robots as the films draw them, in pixels of the screen. */

import type { Item, Point } from "../api";
import { blend, type Tokens } from "../ui/ink";
import { add, boundsOf, direction, distance, isWindow, middle, minus, rotate, times } from "./geometry";
import type { PlanView } from "./view";

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

type Context = CanvasRenderingContext2D;

/** What lies below is drawn first. */
const ORDER = [
  "patch",
  "ramp",
  "steps",
  "wall",
  "opening",
  "obstacle",
  "model",
  "door",
  "light",
  "marker",
  "beacon",
  "mover",
  "mechanism",
  "joint",
  "robot",
];

export function inOrder(items: Item[]): Item[] {
  const rank = (item: Item): number =>
    (ORDER.indexOf(item.kind) + 1 || ORDER.length) * 2 + (item.kind === "opening" ? 1 : 0);
  return [...items].sort((a, b) => rank(a) - rank(b));
}

/** Outlines of an item where it stands, world frame [m]. */
export function outlines(item: Item, stand?: Stand): Point[][] {
  if (!stand || !item.at) return item.polygons;
  if (stand.polygons) return stand.polygons;
  const from = item.at;
  const turn = stand.heading_deg - (item.heading_deg ?? 0);
  return item.polygons.map((polygon) => polygon.map((point) => add(stand.at, rotate(minus(point, from), turn))));
}

/** Draw one item. */
export function drawItem(
  context: Context,
  item: Item,
  view: PlanView,
  palette: Tokens,
  look: Look,
  stand?: Stand,
): void {
  const shapes = outlines(item, stand).map((polygon) => polygon.map((point) => view.toScreen(point)));
  if (look.selected || look.hovered || look.problem) halo(context, shapes, palette, look);
  const draw = DRAWERS[item.kind] ?? drawThing;
  const facing = direction(stand?.heading_deg ?? item.heading_deg ?? 0);
  context.save();
  if (look.gone) context.globalAlpha = 0.25;
  draw({ context, item, shapes, view, palette, look, facing, at: stand?.at ?? item.at });
  context.restore();
  if (look.origin) hatch(context, shapes, palette, look.origin);
  if (look.problem) drawBadge(context, shapes, palette[look.problem], palette.paper);
}

/** Fine lines over what is repeated, rising, and over what is included, falling. */
function hatch(context: Context, shapes: Point[][], palette: Tokens, origin: "repeat" | "include"): void {
  const lines = hatching(origin === "repeat", palette.ground);
  if (!lines) return;
  context.fillStyle = lines;
  for (const shape of shapes) {
    trace(context, shape);
    context.fill();
  }
}

/** Patterns of fine lines, by way and colour. */
const HATCHINGS = new Map<string, CanvasPattern>();
/** Side of the square that is repeated [px]. */
const TILE = 8;

function hatching(rising: boolean, color: string): CanvasPattern | null {
  const key = `${rising} ${color}`;
  const known = HATCHINGS.get(key);
  if (known) return known;
  const tile = Object.assign(document.createElement("canvas"), { width: TILE, height: TILE });
  const context = tile.getContext("2d");
  if (!context) return null;
  context.strokeStyle = color;
  context.lineWidth = 1.5;
  context.globalAlpha = 0.6;
  // Beyond its corners too: the lines go on from square to square.
  for (const shift of [-TILE, 0, TILE]) {
    context.moveTo(shift - 1, rising ? TILE + 1 : -1);
    context.lineTo(shift + TILE + 1, rising ? -1 : TILE + 1);
  }
  context.stroke();
  const pattern = context.createPattern(tile, "repeat");
  if (pattern) HATCHINGS.set(key, pattern);
  return pattern;
}

/** A mark at the upper right of what has a problem, so that its colour is not all that tells. */
function drawBadge(context: Context, shapes: Point[][], color: string, paper: string): void {
  const points = shapes.flat();
  if (points.length === 0) return;
  const [, y0, x1] = boundsOf(points);
  context.fillStyle = color;
  disc(context, [x1 + 5, y0 - 5], 8);
  context.fill();
  context.fillStyle = paper;
  context.font = "700 12px system-ui, sans-serif";
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.fillText("!", x1 + 5, y0 - 4);
}

interface Brush {
  context: Context;
  item: Item;
  shapes: Point[][];
  view: PlanView;
  palette: Tokens;
  look: Look;
  /** Where it faces, world frame. */
  facing: Point;
  at: Point | null;
}

const DRAWERS: Record<string, (brush: Brush) => void> = {
  wall: drawWall,
  opening: drawOpening,
  door: drawLeaf,
  beacon: drawBeacon,
  marker: drawBeacon,
  robot: drawRobot,
  patch: drawPatch,
  light: drawLight,
  lamp: drawLight,
};

function halo(context: Context, shapes: Point[][], palette: Tokens, look: Look): void {
  context.strokeStyle = look.problem ? palette[look.problem] : palette.accent;
  context.lineWidth = look.selected ? 7 : 5;
  context.lineJoin = "round";
  context.globalAlpha = look.selected ? 0.5 : 0.35;
  for (const shape of shapes) {
    trace(context, shape);
    context.stroke();
  }
  context.globalAlpha = 1;
}

function drawWall({ context, shapes, palette, look, item }: Brush): void {
  const low = typeof item.values["height"] === "number" && item.values["height"] < 0.5;
  const fill = low ? palette["wall-low"] : palette.wall;
  context.fillStyle = look.selected ? palette.accent : fill;
  context.strokeStyle = context.fillStyle;
  context.lineWidth = 1;
  for (const shape of shapes) {
    trace(context, shape);
    context.fill();
    context.stroke(); // a hair thick at least, and no seams between pieces
  }
}

function drawOpening({ context, shapes, palette, look, item }: Brush): void {
  const shape = shapes[0];
  if (!shape) return;
  const window = isWindow(item);
  trace(context, shape);
  context.fillStyle = window ? blendSafe(palette.glass, palette.ground, 0.6) : palette.ground;
  context.fill();
  context.strokeStyle = look.selected ? palette.accent : window ? palette.glass : palette["wall-low"];
  context.lineWidth = look.selected ? 2 : 1;
  context.setLineDash(window ? [] : [4, 3]);
  context.stroke();
  context.setLineDash([]);
}

function drawLeaf({ context, shapes, palette, look }: Brush): void {
  context.strokeStyle = look.selected ? palette.accent : palette.wall;
  context.fillStyle = blendSafe(palette.wall, palette.ground, 0.4);
  context.lineWidth = 1;
  for (const shape of shapes) {
    trace(context, shape);
    context.fill();
    context.stroke();
  }
}

function drawThing({ context, item, shapes, palette, look, facing, view, at }: Brush): void {
  const color = typeof item.values["color"] === "string" ? item.values["color"] : "#8a6f4d";
  context.fillStyle = blend(color, palette.ground, 0.5);
  context.strokeStyle = look.selected ? palette.accent : blend(color, palette.ink, 0.45);
  context.lineWidth = look.selected ? 2 : 1.25;
  context.setLineDash(item.values["movable"] || item.values["path"] || item.kind === "mover" ? [5, 3] : []);
  for (const shape of shapes) {
    trace(context, shape);
    context.fill();
    context.stroke();
  }
  context.setLineDash([]);
  drawWay(context, item, view, palette);
  if (at && (item.values["ramp"] || item.values["steps"])) arrow(context, view.toScreen(at), facing, 14);
}

/** Where a thing goes by itself. */
function drawWay(context: Context, item: Item, view: PlanView, palette: Tokens): void {
  const path = item.values["path"] as { points?: Point[]; closed?: boolean } | null | undefined;
  if (!path?.points || !item.at) return;
  context.strokeStyle = palette.muted;
  context.lineWidth = 1.5;
  context.setLineDash([4, 4]);
  context.beginPath();
  for (const point of [item.at, ...path.points, ...(path.closed ? [item.at] : [])])
    context.lineTo(...view.toScreen(point));
  context.stroke();
  context.setLineDash([]);
}

function drawPatch({ context, item, shapes, palette, look }: Brush): void {
  const color = typeof item.values["color"] === "string" ? item.values["color"] : "#b8aa94";
  context.fillStyle = blend(color, palette.ground, 0.65);
  context.strokeStyle = look.selected ? palette.accent : blend(color, palette.ground, 0.3);
  context.setLineDash([6, 4]);
  context.lineWidth = look.selected ? 2 : 1;
  for (const shape of shapes) {
    trace(context, shape);
    context.fill();
    context.stroke();
  }
  context.setLineDash([]);
}

function drawLight({ context, palette, look, at, view, shapes }: Brush): void {
  const place = at ? view.toScreen(at) : centreOf(shapes);
  if (!place) return;
  context.strokeStyle = look.selected ? palette.accent : palette.muted;
  context.lineWidth = 1.5;
  disc(context, place, 5);
  context.stroke();
  for (let k = 0; k < 8; k++) {
    const ray = direction(k * 45);
    line(context, add(place, times(ray, 7.5)), add(place, times(ray, 10)));
  }
}

/** A line of its width with a tick where it faces; a marker is hollow, a reflector a ring, a radio anchor a diamond. */
function drawBeacon({ context, item, shapes, palette, look, facing, at, view }: Brush): void {
  context.strokeStyle = look.selected ? palette.accent : palette.beacon;
  const place = centreOf(shapes) ?? (at ? view.toScreen(at) : null);
  if (!place) return;
  if (!item.values["image"] && !item.values["marker"]) {
    context.fillStyle = palette.paper;
    context.lineWidth = 2;
    if (item.values["anchor"])
      trace(
        context,
        [0, 90, 180, 270].map((turn) => add(place, times(direction(turn), 5))),
      );
    else disc(context, place, 4);
    context.fill();
    context.stroke();
    return;
  }
  const [from, to] = longest(shapes[0] ?? [place, place]);
  const off: Point = [facing[0] * 2, -facing[1] * 2];
  context.lineCap = "butt";
  context.lineWidth = 5;
  line(context, add(from, off), add(to, off));
  context.lineWidth = 2.5;
  line(context, place, add(place, [facing[0] * 9, -facing[1] * 9]));
  if (!item.values["marker"]) return;
  context.strokeStyle = palette.paper;
  context.lineWidth = 2;
  line(context, add(from, off), add(to, off));
}

/** A body, and the links of its arms, seen through. */
function drawRobot({ context, shapes: [body = [], ...links], palette, look, facing, at, view }: Brush): void {
  context.fillStyle = palette.truth;
  context.strokeStyle = look.selected ? palette.accent : palette.paper;
  context.lineWidth = 1;
  trace(context, body);
  context.fill();
  context.stroke();
  const place = at ? view.toScreen(at) : centreOf([body]);
  if (!place) return;
  const box = boundsOf(body);
  const reach = body.length ? Math.max(Math.min(box[2] - box[0], box[3] - box[1]) / 2, 4) : 6;
  context.strokeStyle = palette.paper;
  context.lineWidth = Math.max(2, reach / 5);
  context.lineCap = "round";
  line(context, place, add(place, [facing[0] * reach * 0.8, -facing[1] * reach * 0.8]));
  context.strokeStyle = look.selected ? palette.accent : palette.truth;
  context.lineWidth = 1.25;
  for (const link of links) {
    context.fillStyle = blendSafe(palette.truth, palette.ground, 0.55);
    trace(context, link);
    context.fill();
    context.stroke();
  }
}

/** An arrow in the middle of what leads up or goes by itself. */
export function arrow(context: Context, at: Point, facing: Point, size: number): void {
  const ahead: Point = [facing[0], -facing[1]];
  const across: Point = [-ahead[1], ahead[0]];
  const tip = add(at, times(ahead, size / 2));
  line(context, add(at, times(ahead, -size / 2)), tip);
  for (const side of [1, -1]) line(context, tip, add(add(tip, times(ahead, -5)), times(across, 4 * side)));
}

export function disc(context: Context, [x, y]: Point, radius: number): void {
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
}

export function line(context: Context, from: Point, to: Point): void {
  context.beginPath();
  context.moveTo(...from);
  context.lineTo(...to);
  context.stroke();
}

export function trace(context: Context, shape: Point[]): void {
  context.beginPath();
  for (const point of shape) context.lineTo(...point);
  context.closePath();
}

function centreOf(shapes: Point[][]): Point | null {
  const points = shapes.flat();
  if (points.length === 0) return null;
  const [x0, y0, x1, y1] = boundsOf(points);
  return [(x0 + x1) / 2, (y0 + y1) / 2];
}

/** The middle line of a thin shape: between the middles of its two short edges. */
function longest(shape: Point[]): [Point, Point] {
  const [a, b, c, d] = shape;
  if (!a || !b || !c || !d) return [a ?? [0, 0], b ?? a ?? [0, 0]];
  return distance(a, b) >= distance(b, c) ? [middle(d, a), middle(b, c)] : [middle(a, b), middle(c, d)];
}

function blendSafe(one: string, other: string, share: number): string {
  return one.startsWith("#") && other.startsWith("#") ? blend(one, other, share) : one;
}
