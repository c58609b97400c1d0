/**
 * The plan of a world, to scale: grid, rulers, items, and room for more to be drawn over them.
 *
 *     const plan = new Plan(host);               // fills `host`; follows its size and the theme
 *     plan.setItems(items, bounds);              // draws them; the first time all of them are fitted into the view
 *     plan.stands.set("scout", {at, heading_deg}); plan.refresh(); // things that moved, by name
 *     plan.hiddenKinds.add("robot");             // when you draw the robots yourself
 *
 * Your own drawing, above the items and repainted alone (not with walls and beacons):
 *
 *     plan.overlay.push((context, plan) => {...}); // native 2D context in pixels: plan.view.toScreen([x, y])
 *     plan.drawOver();                             // repaint, at most once a frame
 *
 * Pan: drag (with no tool), Space + drag, middle or right button, two fingers. Zoom: wheel, pinch, `zoomAt`,
 * `key(event)` (+ - 0 arrows). `plan.follow([x, y])` keeps a point in the middle. `plan.itemAt(screen)` is what lies
 * under a pixel. `plan.viewChanged.on(f)` after a pan, zoom or resize. `plan.dispose()` at the end.
 */

import type { Bounds, Item, Path, Point } from "../api";
import { readTokens, type Tokens } from "../ui/ink";
import { Signal } from "../ui/signal";
import { themeChanged } from "../ui/theme";
import { boundsOf, distance, distanceTo, overlaps } from "./geometry";
import { Gestures, type Spot, type Tool } from "./gestures";
import { drawGrid, drawRulers, RULER } from "./grid";
import { drawItem, inOrder } from "./items";
import { drawLabels } from "./labels";
import { Layer } from "./layer";
import { type Look, outlines, type Stand } from "./shapes";
import { PlanView, roundStep } from "./view";

export type Painter = (context: CanvasRenderingContext2D, plan: Plan) => void;

export const keyOf = (path: Path): string => JSON.stringify(path);

export class Plan {
  readonly view = new PlanView();
  readonly viewChanged = new Signal();
  /** Where things stand that are not where their items say, by name or by the key of their path. */
  readonly stands = new Map<string, Stand>();
  /** Items as a drag has them now, by the key of their path. */
  readonly ghosts = new Map<string, Item>();
  /** How items are shown, by the key of their path. */
  looks = new Map<string, Look>();
  readonly hiddenKinds = new Set<string>();
  readonly overlay: Painter[] = [];
  /** What a click of the right button or a long press opens, at a place of the page [px]. */
  menuAsked: ((spot: Spot, at: Point) => void) | null = null;
  rulers = true;
  palette: Tokens = readTokens();
  items: Item[] = [];
  bounds: Bounds = [0, 0, 10, 8];
  private held: Tool | null = null;
  private fitted = false;
  /** Whether all of the world is shown since nobody has moved the paper: then it is still so in another size. */
  private whole = false;
  private readonly under = new Layer((context) => this.paintUnder(context));
  private readonly over = new Layer((context) => this.paintOver(context));
  private readonly gestures: Gestures;
  private readonly endings: (() => void)[] = [];

  constructor(readonly host: HTMLElement) {
    const paper = document.createElement("div");
    paper.className = "plan-paper";
    paper.append(this.under.element, this.over.element);
    host.append(paper);
    this.gestures = new Gestures(this);
    const sizes = new ResizeObserver(() => this.resize());
    sizes.observe(host);
    this.endings.push(
      () => sizes.disconnect(),
      () => this.gestures.dispose(),
      () => this.under.close(),
      () => this.over.close(),
    );
    this.endings.push(themeChanged.on(() => this.recolor()));
  }

  dispose(): void {
    for (const end of this.endings) end();
  }

  /** What the pointer does; null: it moves the paper. */
  get tool(): Tool | null {
    return this.held;
  }

  set tool(tool: Tool | null) {
    if (this.held !== tool) this.gestures.cancel();
    this.held = tool;
    this.gestures.showCursor();
  }

  get dragging(): boolean {
    return this.gestures.dragging;
  }

  /** Take the drag under way back; true if there was one. */
  cancelDrag(): boolean {
    return this.gestures.cancel();
  }

  setItems(items: Item[], bounds: Bounds): void {
    this.items = inOrder(items);
    this.bounds = bounds;
    if (!this.fitted) this.fit();
    this.refresh();
  }

  /** Fit the world into the view anew with the next items: another world was opened. */
  forgetView(): void {
    this.fitted = false;
  }

  /** So many pixels in metres. */
  px(pixels: number): number {
    return pixels / this.view.scale;
  }

  /** The step to which things snap: three pixels at least, finer than the lines that are seen [m]. */
  get step(): number {
    return roundStep(this.view.scale, 3);
  }

  toWorld(screen: Point): Point {
    return this.view.toWorld(screen);
  }

  panBy(dx: number, dy: number): void {
    this.whole = false;
    this.view.left += dx;
    this.view.top += dy;
    this.changed();
  }

  /** Zoom about a pixel, or about the middle. */
  zoomAt(factor: number, screen: Point = [this.view.width / 2, this.view.height / 2]): void {
    this.whole = false;
    this.view.zoom(factor, screen);
    this.changed();
  }

  /** Show all of the world. */
  fit(): void {
    this.view.fit(
      this.bounds,
      this.rulers ? RULER + Math.min(22, 0.06 * Math.min(this.view.width, this.view.height)) : 16,
    );
    if (this.rulers) this.view.left += RULER / 2;
    if (this.rulers) this.view.top += RULER / 2;
    this.fitted = this.whole = this.view.width > 20;
    this.changed();
  }

  /** Bring a point of the world to the middle. */
  follow(at: Point): void {
    this.whole = false;
    this.view.centre(at);
    this.changed();
  }

  /** Keys that any plan knows: + and - zoom, 0 fits, arrows pan; true when it was one of them. */
  key(event: KeyboardEvent): boolean {
    if (event.ctrlKey || event.metaKey || event.altKey) return false;
    const pan: Record<string, Point> = {
      ArrowLeft: [60, 0],
      ArrowRight: [-60, 0],
      ArrowUp: [0, 60],
      ArrowDown: [0, -60],
    };
    const move = pan[event.key];
    if (move) this.panBy(...move);
    else if (event.key === "+" || event.key === "=") this.zoomAt(1.25);
    else if (event.key === "-") this.zoomAt(0.8);
    else if (event.key === "0") this.fit();
    else return false;
    event.preventDefault();
    return true;
  }

  /** Where an item stands, when it is not where it says. */
  standOf(item: Item): Stand | undefined {
    return this.stands.get(keyOf(item.path)) ?? (item.name ? this.stands.get(item.name) : undefined);
  }

  /** What is drawn under a pixel, topmost first: within a few pixels of it. */
  itemsAt(screen: Point, reach = 6): Item[] {
    const at = this.view.toWorld(screen);
    const far = this.px(reach);
    const near = this.shown().filter((item) => this.reaches(item, at, far));
    // What is inside counts before what is near; of equals what is drawn last.
    return near.reverse().sort((a, b) => Number(this.reaches(b, at, 0)) - Number(this.reaches(a, at, 0)));
  }

  itemAt(screen: Point, reach = 6): Item | null {
    return this.itemsAt(screen, reach)[0] ?? null;
  }

  /** Items that lie wholly within bounds [m]. */
  itemsWithin(bounds: Bounds): Item[] {
    return this.shown().filter((item) => {
      const points = outlines(item, this.standOf(item)).flat();
      if (points.length === 0) return item.at !== null && overlaps([...item.at, ...item.at], bounds);
      const [x0, y0, x1, y1] = boundsOf(points);
      return bounds[0] <= x0 && bounds[1] <= y0 && x1 <= bounds[2] && y1 <= bounds[3];
    });
  }

  /** Draw items as they are meanwhile, in the place of those before. */
  ghost(items: Iterable<Item>): void {
    this.ghosts.clear();
    for (const item of items) this.ghosts.set(keyOf(item.path), item);
    this.refresh();
  }

  /** Draw all anew. */
  refresh(): void {
    this.under.drawSoon();
    this.over.drawSoon();
  }

  /** Draw anew what is over the items, and what moves. */
  drawOver(): void {
    this.over.drawSoon();
  }

  private reaches(item: Item, at: Point, far: number): boolean {
    const stand = this.standOf(item);
    const shapes = outlines(item, stand);
    const place = stand?.at ?? item.at;
    if (shapes.length === 0) return place !== null && distance(place, at) <= Math.max(far, this.px(12));
    return shapes.some((polygon) => distanceTo(at, polygon) <= far);
  }

  /** Items that are drawn, as they are. */
  private shown(): Item[] {
    const shown = this.items.filter((item) => !this.hiddenKinds.has(item.kind));
    return this.ghosts.size ? shown.map((item) => this.ghosts.get(keyOf(item.path)) ?? item) : shown;
  }

  private moves(item: Item): boolean {
    return this.ghosts.has(keyOf(item.path)) || this.standOf(item) !== undefined;
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.host;
    if (width === 0 || height === 0) return;
    const middle = this.view.toWorld([this.view.width / 2, this.view.height / 2]);
    Object.assign(this.view, { width, height });
    if (!this.fitted || this.whole) this.fit();
    else {
      this.view.centre(middle);
      this.changed();
    }
    for (const layer of [this.under, this.over]) layer.resize(width, height);
  }

  private recolor(): void {
    this.palette = readTokens();
    this.refresh();
  }

  private changed(): void {
    const { left: x, top: y, scale } = this.view;
    this.host.dataset["view"] = JSON.stringify([x, y, scale]); // where metres lie, for who drives the page from outside
    this.refresh();
    this.viewChanged.emit();
  }

  private paintUnder(context: CanvasRenderingContext2D): void {
    drawGrid(context, this.view, this.palette);
    this.paintItems(
      context,
      this.shown().filter((item) => !this.moves(item)),
    );
  }

  private paintOver(context: CanvasRenderingContext2D): void {
    const moving = this.shown().filter((item) => this.moves(item));
    this.paintItems(context, moving);
    for (const paint of this.overlay) paint(context, this);
    if (this.rulers) drawRulers(context, this.view, this.palette);
  }

  private paintItems(context: CanvasRenderingContext2D, items: Item[]): void {
    const seen = this.view.bounds;
    const near = items.filter((item) => this.isNear(item, seen));
    const isAlone = [...this.looks.values()].filter((look) => look.selected).length === 1;
    for (const item of near) drawItem(context, item, this.view, this.palette, this.lookOf(item), this.standOf(item));
    const named = near.map((item) => {
      const look = this.lookOf(item);
      return {
        item,
        first: Boolean(look.selected || look.hovered),
        turns: isAlone && (look.selected ?? false),
        ...given(this.standOf(item)),
      };
    });
    drawLabels(context, named, this.view, this.palette);
  }

  private lookOf(item: Item): Look {
    return this.looks.get(keyOf(item.path)) ?? {};
  }

  private isNear(item: Item, seen: Bounds): boolean {
    const points = outlines(item, this.standOf(item)).flat();
    return points.length === 0 || overlaps(boundsOf(points), seen);
  }
}

function given(stand: Stand | undefined): { stand?: Stand } {
  return stand ? { stand } : {};
}
