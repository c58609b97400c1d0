/** Names of things beside them, as many as there is room for. */

import type { Bounds, Item, Point } from "../api";
import type { Tokens } from "../ui/ink";
import { boundsOf, direction, overlaps } from "./geometry";
import { outlines, type Stand } from "./shapes";
import type { PlanView } from "./view";

const SIZE = 11;
/** More names than this are shown only where one is zoomed in. */
const MANY = 150;

export interface Named {
  item: Item;
  stand?: Stand;
  /** Selected and hovered things are named first. */
  first: boolean;
  /** It has a handle for turning before its face, as what is selected alone has. */
  turns: boolean;
}

export function drawLabels(context: CanvasRenderingContext2D, things: Named[], view: PlanView, palette: Tokens): void {
  const seen = things.filter(({ item }) => item.name && item.kind !== "wall" && item.kind !== "opening");
  const crowded = seen.length > MANY && view.scale < 60;
  const taken: Bounds[] = [];
  context.font = `${SIZE}px system-ui, sans-serif`;
  context.textBaseline = "middle";
  context.textAlign = "left";
  context.lineJoin = "round";
  for (const thing of [...seen].sort((a, b) => Number(b.first) - Number(a.first))) {
    if (!thing.first && (crowded || view.scale < 20)) continue;
    write(context, thing, view, palette, taken);
  }
}

function write(
  context: CanvasRenderingContext2D,
  thing: Named,
  view: PlanView,
  palette: Tokens,
  taken: Bounds[],
): void {
  const text = thing.item.name ?? "";
  const width = context.measureText(text).width;
  const { at, inside } = place(thing, view, width);
  const [x, y] = at;
  const box: Bounds = [x - 2, y - SIZE / 2 - 1, x + width + 2, y + SIZE / 2 + 1];
  const outside = box[2] < 0 || box[0] > view.width || box[3] < 0 || box[1] > view.height;
  if (outside || (!thing.first && taken.some((other) => overlaps(box, other)))) return;
  taken.push(box);
  context.strokeStyle = palette.ground;
  context.lineWidth = 3;
  if (!inside) context.strokeText(text, x, y);
  context.fillStyle = thing.first || inside ? palette.ink : palette.muted;
  context.fillText(text, x, y);
}

/** Where a name begins: within a large thing, else before a beacon's face or to the right below. */
function place({ item, stand, turns }: Named, view: PlanView, width: number): { at: Point; inside: boolean } {
  const points = outlines(item, stand)
    .flat()
    .map((point) => view.toScreen(point));
  const [x0, y0, x1, y1] = points.length ? boundsOf(points) : boundsOf([view.toScreen(stand?.at ?? item.at ?? [0, 0])]);
  const [x, y] = [(x0 + x1) / 2, (y0 + y1) / 2];
  if (item.kind === "beacon" || item.kind === "marker") {
    const [c, s] = direction(stand?.heading_deg ?? item.heading_deg ?? 0);
    const far = turns ? 60 : 14;
    return { at: [x + c * far - (c < -0.3 ? width : c > 0.3 ? 0 : width / 2), y - s * (far + 3)], inside: false };
  }
  const inside = item.kind !== "robot" && x1 - x0 > width + 8 && y1 - y0 > SIZE + 6;
  return { at: [x - width / 2, inside ? y : y1 + SIZE], inside };
}
