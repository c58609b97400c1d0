/** Put doorways and windows into walls. */

import type { Item, Point, Values } from "../api";
import { add, distance, heading, minus, nearestOn, short, times } from "../plan/geometry";
import type { Spot, Tool } from "../plan/gestures";
import { trace } from "../plan/items";
import type { Plan } from "../plan/plan";
import { word } from "../words/words";
import type { Editor } from "./editor";
import { paintNote } from "./marks";
import { rectangle, segmentsOf } from "./shapes";

const KINDS = {
  door: { width: 0.9 },
  window: { width: 1.2, sill: 0.9, head: 2.0 },
} as const;

interface Place {
  wall: Item;
  segment: number;
  at: number;
  width: number;
  shape: Point[];
}

export class OpeningTool implements Tool {
  readonly cursor = "crosshair";
  private place: Place | null = null;
  private screen: Point = [0, 0];

  constructor(
    private readonly editor: Editor,
    private readonly kind: keyof typeof KINDS,
  ) {
    editor.plan.overlay.push((context, plan) => plan.tool === this && this.paint(context, plan));
  }

  down(spot: Spot): boolean {
    this.hover(spot);
    return this.place !== null || !spot.touch;
  }

  drag(spot: Spot): void {
    this.hover(spot);
  }

  hover(spot: Spot): void {
    this.screen = spot.screen;
    this.place = this.near(spot);
    this.editor.plan.drawOver();
  }

  up(spot: Spot): void {
    this.hover(spot);
    const { place } = this;
    if (!place)
      return this.editor.said.emit(word(this.kind === "door" ? "edit.clickToPutADoorway" : "edit.clickToPutAWindow"));
    if (this.editor.free([place.wall]).length === 0) return;
    const size: Values = { ...KINDS[this.kind], width: place.width };
    const value = { ...(place.segment ? { segment: place.segment } : {}), at: place.at, ...size };
    void this.editor.add([...place.wall.path, "openings"], value);
  }

  cancel(): void {
    this.leave();
  }

  leave(): void {
    this.place = null;
    this.editor.plan.drawOver();
  }

  /** The place in the nearest wall, its middle under the pointer. */
  private near(spot: Spot): Place | null {
    const { plan, items } = this.editor;
    let best: (Place & { far: number }) | null = null;
    for (const wall of items.filter((item) => item.type === "Wall")) {
      segmentsOf(wall).forEach(([from, to], segment) => {
        const { at: foot, along } = nearestOn(spot.world, from, to);
        const far = distance(foot, spot.world);
        const long = distance(from, to);
        if (far > plan.px(spot.touch ? 30 : 20) || (best && far >= best.far) || long < 0.1) return;
        const width = Math.min(KINDS[this.kind].width, Math.floor(100 * long) / 100);
        const wish = along * long - width / 2;
        const at = short(
          Math.min(Math.max(spot.alt ? wish : Math.round(wish / plan.step) * plan.step, 0), long - width),
          3,
        );
        const way = times(minus(to, from), 1 / long);
        const centre = add(from, times(way, at + width / 2));
        const shape = rectangle(centre, heading(way), width, Number(wall.values["thickness"] ?? 0.1));
        best = { wall, segment, at, width, shape, far };
      });
    }
    return best;
  }

  private paint(context: CanvasRenderingContext2D, plan: Plan): void {
    if (!this.place) return;
    trace(
      context,
      this.place.shape.map((point) => plan.view.toScreen(point)),
    );
    context.fillStyle = plan.palette.ground;
    context.fill();
    context.strokeStyle = plan.palette.accent;
    context.lineWidth = 2;
    context.stroke();
    paintNote(
      context,
      plan,
      this.screen,
      word("edit.mFromTheCornerM", { at: this.place.at.toFixed(2), width: this.place.width }),
    );
  }
}
