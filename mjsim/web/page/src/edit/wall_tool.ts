/** Draw walls corner by corner, or a room by a drag from one corner to the opposite one; length and angle of the segment stand beside the pointer. */

import type { Point, Values } from "../api";
import { distance, heading, minus, short, turned } from "../plan/geometry";
import type { Spot, Tool } from "../plan/gestures";
import { disc, trace } from "../plan/items";
import type { Plan } from "../plan/plan";
import { word } from "../words/words";
import type { Editor } from "./editor";
import { paintNote } from "./marks";
import { wallOutlines } from "./shapes";
import { type Snapped, snapCorner } from "./snap";

const THICKNESS = 0.1;
/** A drag is at least so long [px]. */
const DRAGGED = 8;

export class WallTool implements Tool {
  readonly cursor = "crosshair";
  private corners: Point[] = [];
  private next: Snapped | null = null;
  private screen: Point = [0, 0];
  /** Where a drag began, before any corner was set. */
  private from: { at: Point; screen: Point } | null = null;

  constructor(private readonly editor: Editor) {
    editor.plan.overlay.push((context, plan) => plan.tool === this && this.paint(context, plan));
  }

  get isDrawing(): boolean {
    return this.corners.length > 0;
  }

  down(spot: Spot): boolean {
    this.hover(spot);
    this.from = this.next && !this.isDrawing ? { at: this.next.at, screen: spot.screen } : null;
    return true;
  }

  drag(spot: Spot): void {
    this.hover(spot);
  }

  hover(spot: Spot): void {
    const { plan, items } = this.editor;
    const walls = items.filter((item) => item.type === "Wall");
    const reach = plan.px(spot.touch ? 16 : 10);
    this.screen = spot.screen;
    this.next = spot.alt
      ? { at: spot.world, to: null }
      : snapCorner(spot.world, { step: plan.step, reach, walls, from: this.corners });
    plan.drawOver();
  }

  up(spot: Spot): void {
    this.hover(spot);
    const [at, room] = [this.next?.at, this.room()];
    this.from = null;
    if (room.length) {
      this.corners = room;
      return this.finish(true);
    }
    const [first] = this.corners;
    const last = this.corners.at(-1);
    if (!at || (last && distance(at, last) < 1e-6)) return;
    if (first && this.corners.length > 2 && distance(at, first) < 1e-6) return this.finish(true);
    this.corners.push([Number(at[0].toFixed(4)), Number(at[1].toFixed(4))]);
    this.editor.said.emit(this.corners.length === 1 ? word("edit.firstCornerSet") : this.note());
    this.editor.plan.drawOver();
  }

  double(): void {
    this.finish(false);
  }

  cancel(): void {
    this.corners = [];
    this.from = null;
    this.editor.plan.drawOver();
  }

  leave(): void {
    if (!this.isDrawing) this.next = null;
    this.editor.plan.drawOver();
  }

  /** The wall is done: joined to its first corner, or as it stands. */
  finish(closed: boolean): void {
    const points = this.corners;
    this.corners = [];
    if (points.length > 1) {
      const value: Values = { points, ...(closed ? { closed: true } : {}) };
      void this.editor.add(["walls"], value);
    }
    this.editor.plan.drawOver();
  }

  /** Take the last corner back; false when there is none. */
  back(): boolean {
    const had = this.corners.pop() !== undefined;
    this.editor.plan.drawOver();
    return had;
  }

  /** The corners of a room that is being dragged; none while nothing is. */
  private room(): Point[] {
    const { from, next } = this;
    if (!from || !next || distance(from.screen, this.screen) < DRAGGED) return [];
    const [[left, bottom], [right, top]] = [from.at, next.at];
    return left === right || bottom === top
      ? []
      : [
          [left, bottom],
          [right, bottom],
          [right, top],
          [left, top],
        ].map(([x = 0, y = 0]) => [short(x), short(y)]);
  }

  private note(): string {
    const [one, , other] = this.room();
    if (one && other) return `${Math.abs(other[0] - one[0]).toFixed(2)} × ${Math.abs(other[1] - one[1]).toFixed(2)} m`;
    const last = this.corners.at(-1);
    const at = this.next?.at;
    if (!last || !at) return at ? `${at[0].toFixed(2)}, ${at[1].toFixed(2)} m` : "";
    const [first] = this.corners;
    const closes = first && this.corners.length > 2 && distance(at, first) < 1e-6;
    const length = word("edit.lengthAndHeading", {
      metres: distance(at, last).toFixed(2),
      degrees: Math.round(turned(heading(minus(at, last)))),
    });
    return closes ? word("edit.closeTheRoom", { length }) : length;
  }

  private paint(context: CanvasRenderingContext2D, plan: Plan): void {
    if (!this.next) return;
    const room = this.room();
    const line = room.length ? room : [...this.corners, this.next.at];
    context.fillStyle = plan.palette.accent;
    context.globalAlpha = 0.55;
    for (const shape of wallOutlines(line, room.length > 0, THICKNESS)) {
      trace(
        context,
        shape.map((point) => plan.view.toScreen(point)),
      );
      context.fill();
    }
    context.globalAlpha = 1;
    context.strokeStyle = plan.palette.accent;
    context.lineWidth = 1.5;
    for (const corner of this.corners) {
      context.fillStyle = plan.palette.paper;
      disc(context, plan.view.toScreen(corner), 4);
      context.fill();
      context.stroke();
    }
    disc(context, plan.view.toScreen(this.next.at), this.next.to === "end" || this.next.to === "wall" ? 8 : 4);
    context.stroke();
    paintNote(context, plan, this.screen, this.note());
  }
}
