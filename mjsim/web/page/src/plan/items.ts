/** Drawing of items by their shapes, with the look of all pictures, in pixels of the screen. */

import type { Item, Point } from "../api";
import type { Tokens } from "../ui/ink";
import { add, boundsOf, times } from "./geometry";
import { filled, type Ink, inkOf, type Look, MM, placed, type Stand } from "./shapes";
import type { PlanView } from "./view";

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

/** Draw one item. */
export function drawItem(
  context: Context,
  item: Item,
  view: PlanView,
  palette: Tokens,
  look: Look,
  stand?: Stand,
): void {
  const areas = filled(item, stand).map((polygons) =>
    polygons.map((polygon) => polygon.map((at) => view.toScreen(at))),
  );
  const held = areas.flat().length ? areas.flat() : around(item, view, stand);
  if (look.selected || look.hovered || look.problem) halo(context, held, palette, look);
  context.save();
  if (look.gone) context.globalAlpha = 0.25;
  item.shapes.forEach((shape, k) => {
    const parts = shape.parts ? placed(item, shape, view, stand) : (areas[k] ?? []);
    const closed = !shape.parts || shape.closed === true;
    paint(context, parts, closed, inkOf(shape, closed, palette, look));
  });
  context.restore();
  if (look.origin) hatch(context, held, palette, look.origin);
  if (look.problem) drawBadge(context, held, palette[look.problem], palette.paper);
}

/** What stands for the outline of an item that is drawn by symbols alone. */
function around(item: Item, view: PlanView, stand?: Stand): Point[][] {
  const at = stand?.at ?? item.at;
  if (!at) return [];
  const corners: Point[] = [
    [-2, -2],
    [2, -2],
    [2, 2],
    [-2, 2],
  ];
  return [corners.map((corner) => add(view.toScreen(at), times(corner, MM)))];
}

function paint(context: Context, parts: Point[][], closed: boolean, { fill, line, width, dash }: Ink): void {
  context.lineWidth = width;
  context.lineCap = "butt";
  context.setLineDash(dash ? [dash, dash / 2] : []);
  if (fill) context.fillStyle = fill;
  if (line) context.strokeStyle = line;
  for (const part of parts) {
    trace(context, part, closed);
    if (fill) context.fill();
    if (line) context.stroke();
  }
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

export function trace(context: Context, shape: Point[], closed = true): void {
  context.beginPath();
  for (const point of shape) context.lineTo(...point);
  if (closed) context.closePath();
}
