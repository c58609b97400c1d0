/** Select, drag, turn and resize with the pointer. */

import type { Bounds, Item, Point } from "../api";
import { boundsOf, distance, heading, minus, turned } from "../plan/geometry";
import type { Spot, Tool } from "../plan/gestures";
import { disc, line } from "../plan/items";
import { keyOf, type Plan } from "../plan/plan";
import { word } from "../words/words";
import type { Editor } from "./editor";
import { byThemselves, groupOf, middleOf, turnedAlike, wholeGroup, withGroups } from "./groups";
import { withPictures } from "./hung";
import { canLift, heightOf, lifted } from "./lift";
import { paintBand, paintFrame, paintNote, paintViews } from "./marks";
import { signed, sizeNote } from "./notes";
import {
  type Changed,
  canTurn,
  cornersOf,
  faceNear,
  type Handle,
  handlesOf,
  isJoint,
  isWall,
  moved,
  spun,
} from "./shapes";
import { snapCorner, toGrid } from "./snap";

/** A drag begins after so many pixels; before that it is a click. */
const THRESHOLD = 3;
const HANDLE = 4.5;
const STEM = 30;
/** To what a thing is lifted that does not snap [m]. */
const FINEST = 0.001;

type Drag =
  | { kind: "items"; items: Item[]; grabbed: Item }
  | { kind: "handle"; handle: Handle; item: Item }
  | { kind: "turn"; items: Item[]; pivot: Point; from: number }
  | { kind: "lift"; items: Item[] }
  | { kind: "pull"; part: string }
  | { kind: "band"; kept: Item[] };

export class SelectTool implements Tool {
  readonly cursor = "default";
  private held: Drag | null = null;
  private from: Spot | null = null;
  private now: Spot | null = null;
  private moving = false;
  private changed: Changed[] = [];
  private note = "";

  constructor(private readonly editor: Editor) {
    editor.poser.changed.on(() => editor.plan.drawOver());
    editor.plan.overlay.push((context, plan) => editor.plan.tool === this && this.paint(context, plan));
  }

  /** Of a group take the one thing alone; of one thing its fields. */
  double(spot: Spot): void {
    const { editor } = this;
    const item = editor.plan.itemAt(spot.screen);
    if (item && groupOf(item) !== null && editor.selected.length > 1) editor.select([item]);
    else if (editor.selected.length) editor.asked.emit();
  }

  down(touched: Spot): boolean {
    const spot = { ...touched, shift: touched.shift || this.editor.adding };
    [this.from, this.now, this.moving, this.changed] = [spot, spot, false, []];
    this.held = this.grab(spot);
    return this.held !== null;
  }

  /** Take what is selected by a handle in 3-D; from there on it is dragged as on the plan. */
  take(kind: "move" | "turn" | "lift", spot: Spot): void {
    const items = this.editor.selected;
    const [item] = items;
    if (!item) return;
    [this.from, this.now, this.moving, this.changed] = [spot, spot, true, []];
    const pivot = middleOf(items);
    if (kind === "turn") this.held = { kind, items, pivot, from: heading(minus(spot.world, pivot)) };
    else this.held = kind === "lift" ? { kind, items } : { kind: "items", items, grabbed: item };
  }

  /** Whether something is dragged. */
  get isHolding(): boolean {
    return this.held !== null;
  }

  /** What the drag comes to, in words. */
  get word(): string {
    return this.note;
  }

  drag(spot: Spot): void {
    this.now = spot;
    if (!this.from || !this.held) return;
    this.moving ||= distance(spot.screen, this.from.screen) > THRESHOLD;
    if (!this.moving) return;
    if (this.held.kind === "band") this.editor.pick([...this.held.kept, ...this.banded()]);
    else if (this.held.kind === "pull") this.pull(this.held.part, this.from, spot);
    else this.editor.preview((this.changed = withPictures(this.changes(this.held, spot), this.editor.items)));
    this.editor.plan.drawOver();
  }

  up(): void {
    const drag = this.held;
    if (drag?.kind === "pull") void this.editor.poser.keep();
    else if (drag && this.moving && drag.kind !== "band") void this.editor.commit(this.changed);
    else if (drag?.kind === "items" && !this.from?.shift) this.settle(drag.grabbed);
    else if (drag?.kind === "band" && !this.moving && !this.from?.shift) this.editor.select([]);
    this.held = null;
    this.note = "";
    this.editor.plan.drawOver();
  }

  cancel(): void {
    this.held = null;
    this.note = "";
    this.editor.poser.forget();
    this.editor.forget();
  }

  hover(spot: Spot): void {
    const handle = this.handleAt(spot);
    const turner = !handle && (this.handAt(spot) || this.turnerAt(spot));
    const item = handle || turner ? null : this.editor.plan.itemAt(spot.screen);
    this.editor.hover(item);
    this.editor.plan.host.style.cursor = handle ? handle.handle.cursor : turner ? "grab" : item ? "move" : "default";
  }

  leave(): void {
    this.editor.hover(null);
  }

  private grab(spot: Spot): Drag | null {
    const handle = this.handleAt(spot);
    if (handle) return { kind: "handle", ...handle };
    const turner = this.handAt(spot) ?? this.turnerAt(spot);
    if (turner) return turner;
    const item = this.editor.plan.itemAt(spot.screen, spot.touch ? 12 : 6);
    if (item) return this.grabItem(item, spot.shift);
    if (spot.touch && !this.editor.adding) {
      this.editor.select([]);
      return null; // a finger on free paper moves it
    }
    return { kind: "band", kept: spot.shift ? this.editor.selected : [] };
  }

  private grabItem(item: Item, shift: boolean): Drag | null {
    const selected = this.editor.selected;
    const isIn = selected.some((other) => keyOf(other.path) === keyOf(item.path));
    const own = new Set(withGroups([item], this.editor.items).map(({ path }) => keyOf(path)));
    if (shift && isIn) this.editor.select(selected.filter(({ path }) => !own.has(keyOf(path))));
    else if (!isIn) this.editor.pick(shift ? [...selected, item] : [item]);
    if (shift && isIn) return { kind: "band", kept: this.editor.selected };
    if (isJoint(item) && item.name && this.alone())
      return this.editor.free([item]).length ? { kind: "pull", part: item.name } : null;
    return { kind: "items", items: this.editor.selected, grabbed: item };
  }

  /** After a press without a drag: all of the group, unless one of it was taken alone. */
  private settle(grabbed: Item): void {
    const alone = this.alone();
    if (!alone || keyOf(alone.path) !== keyOf(grabbed.path)) this.editor.pick([grabbed]);
  }

  private changes(drag: Drag, spot: Spot): Changed[] {
    if (drag.kind === "handle") return [this.resized(drag.handle, spot)];
    if (drag.kind === "turn") return this.spun(drag, spot);
    if (drag.kind === "lift") return this.lifted(drag.items, spot);
    if (drag.kind === "band" || drag.kind === "pull") return [];
    const items = drag.items.filter((item) => !item.fixed);
    if (items.length < drag.items.length && this.changed.length === 0) this.editor.free(drag.items);
    return items.length ? this.shifted(items, drag.grabbed, spot) : [];
  }

  /** Drag the body of a joint, or the hand of a person; what it is then, the server says. */
  private pull(part: string, from: Spot, to: Spot): void {
    this.editor.poser.follow({ pull: { look: "above", part, start: from.world, end: to.world } });
  }

  private handAt(spot: Spot): Drag | null {
    const hands = Object.entries(this.hands());
    const near = hands.find(([, [x, y]]) => {
      return distance(this.editor.plan.view.toScreen([x, y]), spot.screen) <= (spot.touch ? 20 : 9);
    });
    return near ? { kind: "pull", part: near[0] } : null;
  }

  /** The hands of the person that is selected, that can be led. */
  private hands(): Record<string, [number, number, number]> {
    const item = this.alone();
    return item?.type === "Person" && !item.fixed ? (this.editor.poser.pose?.hands ?? {}) : {};
  }

  private resized(handle: Handle, spot: Spot): Changed {
    const { plan, items } = this.editor;
    const mine = this.held?.kind === "handle" ? keyOf(this.held.item.path) : "";
    const walls = items.filter((item) => isWall(item) && keyOf(item.path) !== mine);
    const snap = { step: plan.step, reach: plan.px(9), walls };
    const to = spot.alt
      ? spot.world
      : handle.corner !== undefined
        ? snapCorner(spot.world, snap).at
        : toGrid(spot.world, plan.step);
    const changed = handle.drawn(to);
    this.note = sizeNote(changed.ghost, handle.corner);
    return changed;
  }

  private spun(drag: { items: Item[]; pivot: Point; from: number }, spot: Spot): Changed[] {
    const angle = turned(heading(minus(spot.world, drag.pivot)) - drag.from);
    const [only, ...more] = drag.items;
    const base = more.length || !only || isWall(only) ? 0 : (only.heading_deg ?? 0);
    const step = spot.alt || spot.shift ? 1 : 15;
    const by = Math.round((base + angle) / step) * step - base;
    this.note = `${Math.round(turned(base + by))}°`;
    return turnedAlike(drag.items, by, this.editor.items);
  }

  private lifted(items: Item[], { rise = 0, alt }: Spot): Changed[] {
    const { step } = this.editor.plan;
    const changed = byThemselves(items)
      .filter((item) => !item.fixed && canLift(item))
      .map((item) => lifted(item, rise, alt ? FINEST : step));
    const [first] = changed;
    this.note = first ? word("edit.metresHigh", { metres: heightOf(first.ghost).toFixed(2) }) : "";
    return changed;
  }

  private shifted(items: Item[], grabbed: Item, spot: Spot): Changed[] {
    const { plan } = this.editor;
    const raw = minus(spot.world, this.from?.world ?? spot.world);
    const alone = items.length === 1 ? items[0] : undefined;
    if (alone?.type === "Beacon" && !spot.alt && typeof alone.values["on"] !== "string") {
      const hung = this.hung(alone, spot);
      if (hung) return [hung];
    }
    const anchor = isWall(grabbed) ? cornersOf(grabbed)[0] : grabbed.at;
    const isOpening = grabbed.type === "Opening";
    let by: Point = raw;
    if (!spot.alt && anchor && !isOpening) {
      const aim = toGrid([anchor[0] + raw[0], anchor[1] + raw[1]], plan.step);
      by =
        spot.shift && Math.abs(raw[0]) < Math.abs(raw[1])
          ? [0, aim[1] - anchor[1]]
          : spot.shift
            ? [aim[0] - anchor[0], 0]
            : minus(aim, anchor);
    }
    this.note = isOpening ? "" : `${signed(by[0])}, ${signed(by[1])} m`;
    const whole = items.filter((item) => item.type !== "Opening" || items.length === 1);
    const changed = byThemselves(whole).map((item) => moved(item, by, this.editor.items));
    if (isOpening && changed[0])
      this.note = word("edit.fromTheCorner", { metres: Number(changed[0].ghost.values["at"]).toFixed(2) });
    return [...changed, ...this.openingsOf(whole, by)];
  }

  /** Openings of walls that are moved go along on the plan; the text has them by their wall: nothing is written. */
  private openingsOf(walls: Item[], by: Point): Changed[] {
    const keys = new Set(walls.filter(isWall).map((wall) => keyOf(wall.path)));
    const openings = this.editor.items.filter(
      (item) => item.type === "Opening" && keys.has(keyOf(item.path.slice(0, -2))),
    );
    return openings.map((item) => {
      const polygons = item.polygons.map((polygon) => polygon.map(([x, y]): Point => [x + by[0], y + by[1]]));
      return { ghost: { ...item, polygons }, changes: [] };
    });
  }

  /** A picture near a wall hangs on its face and looks into the room. */
  private hung(item: Item, spot: Spot): Changed | null {
    const { plan, items } = this.editor;
    const face = faceNear(spot.world, items.filter(isWall), Math.max(plan.px(14), 0.15));
    if (!face || !item.at) return null;
    const turn = spun(item, turned(face.heading_deg - (item.heading_deg ?? 0)));
    const place = moved(turn.ghost, minus(face.at, item.at), items);
    this.note = word("edit.onTheWall2", { heading_deg: Math.round(face.heading_deg) });
    const isTurned = Math.abs(turned(face.heading_deg - (item.heading_deg ?? 0))) > 0.01;
    return { ghost: place.ghost, changes: [...place.changes, ...(isTurned ? turn.changes : [])] };
  }

  private banded(): Item[] {
    if (!this.from || !this.now) return [];
    const [a, b] = [this.from.world, this.now.world];
    const bounds: Bounds = [Math.min(a[0], b[0]), Math.min(a[1], b[1]), Math.max(a[0], b[0]), Math.max(a[1], b[1])];
    return this.editor.plan.itemsWithin(bounds).filter((item) => item.type !== "Opening");
  }

  private alone(): Item | null {
    const items = this.editor.selected;
    return items.length === 1 ? (items[0] ?? null) : null;
  }

  /** Handles of an item, when it is drawn large enough to have room for them. */
  private handles(item: Item): Handle[] {
    const { plan, items } = this.editor;
    const handles = handlesOf(item, items);
    if (isWall(item)) return this.wallHandles(item, handles);
    const [x0, y0, x1, y1] = boundsOf(handles.map(({ at }) => plan.view.toScreen(at)));
    const room = Math.max(x1 - x0, y1 - y0);
    return handles.slice(0, room < 18 ? 0 : room < 40 ? 4 : handles.length);
  }

  /** A new corner is offered where a segment is long on the screen. */
  private wallHandles(wall: Item, handles: Handle[]): Handle[] {
    const corners = cornersOf(wall);
    return handles.filter(
      ({ fresh, at }) => !fresh || corners.every((corner) => distance(corner, at) > this.editor.plan.px(26)),
    );
  }

  private handleAt(spot: Spot): { handle: Handle; item: Item } | null {
    const item = this.alone();
    if (!item) return null;
    const near = spot.touch ? 20 : 9;
    const far = (handle: Handle): number => distance(this.editor.plan.view.toScreen(handle.at), spot.screen);
    const handle = this.handles(item).sort((a, b) => far(a) - far(b))[0];
    return handle && far(handle) <= near ? { handle, item } : null;
  }

  private turnerAt(spot: Spot): Drag | null {
    const ends = this.turner();
    if (!ends || distance(ends[1], spot.screen) > (spot.touch ? 20 : 10)) return null;
    const items = this.turned();
    const pivot = middleOf(items);
    return { kind: "turn", items, pivot, from: heading(minus(this.editor.plan.view.toWorld(ends[1]), pivot)) };
  }

  /** What the handle for turning turns: one thing, or all of a group. */
  private turned(): Item[] {
    const { selected, items } = this.editor;
    const isOne = selected.length === 1 && selected.every(canTurn);
    return (isOne || wholeGroup(selected, items)) && selected.every((item) => !item.fixed) ? selected : [];
  }

  /** Stem and knob of the handle for turning, in pixels. */
  private turner(): [Point, Point] | null {
    const { plan } = this.editor;
    const { view, ghosts } = plan;
    const shown = this.turned().map((item) => ghosts.get(keyOf(item.path)) ?? item);
    const [first, ...more] = shown;
    if (!first) return null;
    const pivot = view.toScreen(middleOf(shown));
    const upright = more.length > 0 || isWall(first);
    const angle = upright ? 90 : (first.heading_deg ?? 0);
    const outline = shown.flatMap(({ polygons }) => polygons.flat());
    const far = Math.max(0, ...outline.map((point) => distance(view.toScreen(point), pivot)));
    const reach = (upright ? Math.min(far, more.length ? 120 : 40) : far) + STEM;
    const [c, s] = [Math.cos((angle * Math.PI) / 180), Math.sin((angle * Math.PI) / 180)];
    return [pivot, [pivot[0] + c * reach, pivot[1] - s * reach]];
  }

  private paint(context: CanvasRenderingContext2D, plan: Plan): void {
    const item = this.alone();
    context.lineWidth = 1.5;
    if (item) paintViews(context, plan, plan.ghosts.get(keyOf(item.path)) ?? item);
    this.paintTurner(context, plan);
    if (item) this.paintHandles(context, plan, item);
    if (this.held?.kind === "band" && this.moving && this.from && this.now)
      paintBand(context, plan, this.from.screen, this.now.screen);
    const note = this.held?.kind === "pull" ? this.editor.poser.note : this.note;
    if (note && this.now && this.moving) paintNote(context, plan, this.now.screen, note);
  }

  private paintTurner(context: CanvasRenderingContext2D, plan: Plan): void {
    const group = this.editor.selected.length > 1 ? this.turned() : [];
    context.strokeStyle = plan.palette.accent;
    context.fillStyle = plan.palette.paper;
    paintFrame(context, plan, group);
    const stem = this.turner();
    if (!stem) return;
    context.globalAlpha = 0.6;
    line(context, ...stem);
    context.globalAlpha = 1;
    disc(context, stem[1], 5.5);
    context.fill();
    context.stroke();
  }

  private paintHandles(context: CanvasRenderingContext2D, plan: Plan, item: Item): void {
    const shown = plan.ghosts.get(keyOf(item.path)) ?? item;
    for (const [x, y] of Object.values(this.hands())) {
      disc(context, plan.view.toScreen([x, y]), 5.5);
      context.fill();
      context.stroke();
    }
    for (const { at, corner, fresh } of this.handles(shown)) {
      const [x, y] = plan.view.toScreen(at);
      context.beginPath();
      if (fresh) context.arc(x, y, HANDLE - 1.5, 0, 2 * Math.PI);
      else if (corner === undefined) context.rect(x - HANDLE, y - HANDLE, 2 * HANDLE, 2 * HANDLE);
      else context.arc(x, y, HANDLE + 1, 0, 2 * Math.PI);
      context.fill();
      context.stroke();
    }
  }
}
