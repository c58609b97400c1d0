/** Mouse, fingers and wheel on the plan: panning and zooming, and what a tool makes of the rest. */

import type { Point } from "../api";
import { distance, middle } from "./geometry";

/** Where a pointer is, and what is held with it. */
export interface Spot {
  world: Point;
  screen: Point;
  shift: boolean;
  alt: boolean;
  command: boolean;
  touch: boolean;
  /** How far above where it was taken [m], in 3-D. */
  rise?: number;
}

/** What the pointer does on the plan. `down` tells whether it takes the drag; what it leaves moves the paper. */
export interface Tool {
  readonly cursor?: string;
  down(spot: Spot): boolean;
  drag?(spot: Spot): void;
  up?(spot: Spot): void;
  /** The pointer moves with nothing held. */
  hover?(spot: Spot): void;
  double?(spot: Spot): void;
  leave?(): void;
  /** The drag is taken back: a second finger, Escape, or the system took the pointer. */
  cancel?(): void;
}

/** What gestures do to the plan. */
export interface Paper {
  readonly host: HTMLElement;
  readonly tool: Tool | null;
  toWorld(screen: Point): Point;
  panBy(dx: number, dy: number): void;
  zoomAt(factor: number, screen: Point): void;
  /** The menu of what lies there is wanted, at a place of the page [px]. */
  menuAsked?: ((spot: Spot, at: Point) => void) | null;
}

/** The right button may slip so far and is still a click [px]. */
const SLIP = 4;
/** A finger that rests for so long asks for the menu [ms], and may tremble by so much [px]. */
const LONG = 500;
const TREMBLE = 8;

type Mode = "none" | "pan" | "tool" | "pinch";

export class Gestures {
  private readonly pointers = new Map<number, Point>();
  private mode: Mode = "none";
  private last: Point = [0, 0];
  private space = false;
  /** Where the right button went down; null when it moved the paper since. */
  private right: Point | null = null;
  /** The finger that may become a long press: the timer of it, and where it went down. */
  private resting = 0;
  private rest: Point = [0, 0];
  private readonly over = new AbortController();

  constructor(private readonly paper: Paper) {
    const { host } = paper;
    const { signal } = this.over;
    host.style.touchAction = "none";
    host.addEventListener("pointerdown", (event) => this.down(event), { signal });
    host.addEventListener("pointermove", (event) => this.move(event), { signal });
    host.addEventListener("pointerup", (event) => this.up(event), { signal });
    host.addEventListener("pointercancel", (event) => this.lost(event), { signal });
    host.addEventListener("pointerleave", () => this.mode === "none" && paper.tool?.leave?.(), { signal });
    host.addEventListener("dblclick", (event) => paper.tool?.double?.(this.spot(event)), { signal });
    host.addEventListener("wheel", (event) => this.wheel(event), { signal, passive: false });
    host.addEventListener("contextmenu", (event) => event.preventDefault(), { signal });
    window.addEventListener("keydown", (event) => this.held(event, true), { signal });
    window.addEventListener("keyup", (event) => this.held(event, false), { signal });
    // The key may be released in another window.
    window.addEventListener("blur", () => (this.space = false), { signal });
  }

  get dragging(): boolean {
    return this.mode === "tool";
  }

  /** Take the tool's drag back, if there is one. */
  cancel(): boolean {
    if (this.mode !== "tool") return false;
    this.mode = "none";
    this.paper.tool?.cancel?.();
    return true;
  }

  dispose(): void {
    window.clearTimeout(this.resting);
    this.over.abort();
  }

  private held(event: KeyboardEvent, down: boolean): void {
    if (event.code !== "Space") return;
    this.space = down && this.paper.host.matches(":hover");
    if (this.mode === "none") this.showCursor();
  }

  showCursor(): void {
    const hand = this.mode === "pan" ? "grabbing" : this.space ? "grab" : (this.paper.tool?.cursor ?? "grab");
    this.paper.host.style.cursor = hand;
  }

  private down(event: PointerEvent): void {
    this.paper.host.focus({ preventScroll: true });
    this.paper.host.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, this.screen(event));
    this.last = this.rest = this.screen(event);
    window.clearTimeout(this.resting);
    if (this.pointers.size === 2) return this.beginPinch();
    if (this.pointers.size > 2) return;
    this.right = event.button === 2 ? this.last : null;
    const pan = event.button === 1 || event.button === 2 || this.space;
    this.mode = !pan && this.paper.tool?.down(this.spot(event)) ? "tool" : "pan";
    this.showCursor();
    if (event.pointerType === "touch") this.resting = window.setTimeout(() => this.longPress(event), LONG);
  }

  private beginPinch(): void {
    if (this.mode === "tool") this.paper.tool?.cancel?.();
    this.mode = "pinch";
  }

  private move(event: PointerEvent): void {
    const now = this.screen(event);
    if (this.mode === "none") return this.paper.tool?.hover?.(this.spot(event));
    if (this.mode === "pinch") return this.pinch(event.pointerId, now);
    if (distance(this.rest, now) > TREMBLE) window.clearTimeout(this.resting);
    if (this.right && distance(this.right, now) <= SLIP) return;
    this.right = null;
    if (this.mode === "pan") this.paper.panBy(now[0] - this.last[0], now[1] - this.last[1]);
    else this.paper.tool?.drag?.(this.spot(event));
    this.last = now;
  }

  /** Two fingers: their middle moves the paper, their distance its scale. */
  private pinch(id: number, now: Point): void {
    const before = [...this.pointers.values()];
    this.pointers.set(id, now);
    const after = [...this.pointers.values()];
    const [a, b, c, d] = [before[0], before[1], after[0], after[1]];
    if (!a || !b || !c || !d) return;
    const [from, to] = [middle(a, b), middle(c, d)];
    this.paper.panBy(to[0] - from[0], to[1] - from[1]);
    this.paper.zoomAt(distance(c, d) / Math.max(distance(a, b), 1), to);
  }

  private up(event: PointerEvent): void {
    window.clearTimeout(this.resting);
    this.pointers.delete(event.pointerId);
    if (this.pointers.size > 0) return;
    const was = this.mode;
    this.mode = "none";
    if (was === "tool") this.paper.tool?.up?.(this.spot(event));
    this.showCursor();
    if (this.right) this.paper.menuAsked?.(this.spot(event), [event.clientX, event.clientY]);
    this.right = null;
  }

  /** A finger has rested: what it dragged goes back, and the menu comes. Not every browser tells of it by itself. */
  private longPress(event: PointerEvent): void {
    this.cancel();
    this.mode = "none";
    this.pointers.clear();
    this.paper.menuAsked?.(this.spot(event), [event.clientX, event.clientY]);
  }

  private lost(event: PointerEvent): void {
    window.clearTimeout(this.resting);
    this.pointers.delete(event.pointerId);
    this.cancel();
    this.mode = "none";
  }

  private wheel(event: WheelEvent): void {
    event.preventDefault();
    const unit = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 16 : 1;
    if (event.shiftKey && !event.ctrlKey) return this.paper.panBy(-(event.deltaY + event.deltaX) * unit, 0);
    // A pinch on a track pad comes as a wheel with Ctrl, in smaller steps.
    const speed = event.ctrlKey ? 0.01 : 0.0015;
    this.paper.zoomAt(Math.exp(-event.deltaY * unit * speed), this.screen(event));
  }

  private screen(event: MouseEvent): Point {
    const box = this.paper.host.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  private spot(event: MouseEvent): Spot {
    const screen = this.screen(event);
    const touch = event instanceof PointerEvent && event.pointerType === "touch";
    const command = event.ctrlKey || event.metaKey;
    return { world: this.paper.toWorld(screen), screen, shift: event.shiftKey, alt: event.altKey, command, touch };
  }
}
