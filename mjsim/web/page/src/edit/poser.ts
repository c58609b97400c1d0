/** Mechanisms and people in another pose: the server works it out while a hand drags, and it is written at the end. */

import { ApiError, type Change, type Item, type Look, type Point, type Pose, type PoseWish } from "../api";
import { keyOf } from "../plan/plan";
import { debounced, newestWins, Signal } from "../ui/signal";
import type { Editor } from "./editor";

/** What turns a joint by a degree shifts one that slides by so much [m]. */
const SLIDE = 1 / 150;
/** Steps of the keyboard that follow each other so quickly are one change [ms]. */
const PAUSE = 200;

export class Poser {
  /** The pose of what is selected, as a drag has it now; null: nothing is selected that has one. */
  pose: Pose | null = null;
  /** What does not come out as it was dragged. */
  note = "";
  readonly changed = new Signal();
  /** As the text has it. */
  private resting: Pose | null = null;
  private seen: Look = "side";
  private good: Change[] = [];
  private wish: PoseWish | null = null;
  private answered: PoseWish | null = null;
  /** Whether it is being written, and what is to be done after that. */
  private keeping = false;
  private later: { wish: PoseWish; keep: boolean } | null = null;
  private shown = "";
  /** What did not come out as it was asked last: it stays beside the text that came of it. */
  private left = "";
  private owner = "";
  private nudged: Point = [0, 0];
  private turned = 0;
  private readonly ask = newestWins((wish: PoseWish) => this.answer(wish));
  private readonly keepSoon = debounced(() => void this.keep(), PAUSE);

  constructor(private readonly editor: Editor) {
    const { document } = editor;
    document.parsedChanged.on(() => this.rest());
    document.selectionChanged.on(() => this.rest());
    document.finishing.on(() => this.keepSoon.now());
  }

  /** The mechanism or person that is selected, or of which a joint is. */
  get subject(): Item | null {
    const [only, more] = this.editor.selected;
    if (!only || more || !["mechanisms", "people"].includes(String(only.path[0]))) return null;
    return this.editor.document.itemAt(only.path.slice(0, 2));
  }

  /** The joint that is selected. */
  get joint(): Item | null {
    const [only, more] = this.editor.selected;
    return only && !more && only.kind === "joint" ? only : null;
  }

  get look(): Look {
    return this.seen;
  }

  set look(look: Look) {
    this.seen = look;
    this.shown = "";
    this.rest();
  }

  /** Whether something is dragged or waits to be written. */
  get busy(): boolean {
    return this.wish !== null;
  }

  /** Show how it would be. */
  follow(wish: PoseWish): void {
    if (!this.subject) return;
    if (this.keeping) return void (this.later = { wish, keep: false });
    this.wish = wish;
    void this.ask(wish);
  }

  /** Write what is shown: one step of undo. */
  async keep(): Promise<void> {
    if (this.keeping && this.later) this.later.keep = true;
    if (!this.wish || this.keeping) return;
    this.keeping = true;
    if (this.answered !== this.wish) await this.ask(this.wish);
    if (this.good.length) await this.editor.apply(this.good);
    else this.editor.forget();
    this.end(this.note);
  }

  /** Give up what was dragged. */
  forget(): void {
    if (!this.busy || this.keeping) return;
    this.editor.forget();
    this.end("");
  }

  /** Shift the body of the selected joint by a step of the keyboard; false when no joint is selected. */
  nudge(by: Point): boolean {
    const { joint } = this;
    if (!joint?.name) return false;
    const [x, y] = (this.nudged = [this.nudged[0] + by[0], this.nudged[1] + by[1]]);
    const [start] = middles(joint);
    if (start) this.step({ pull: { look: "above", part: joint.name, start, end: [start[0] + x, start[1] + y] } });
    return true;
  }

  /** Turn the selected joint by a step of the keyboard; false when none is selected. */
  turn(degrees: number): boolean {
    const { joint } = this;
    if (!joint?.name) return false;
    const before = this.resting?.values.find(({ name }) => name === joint.name);
    this.turned += degrees;
    const by = this.turned * (before?.unit === "m" ? SLIDE : 1);
    if (before) this.step({ values: { [before.name]: before.value + by } });
    return true;
  }

  private step(wish: PoseWish): void {
    if (this.editor.free([...this.editor.selected]).length === 0) return;
    this.follow(wish);
    this.keepSoon();
  }

  private end(note: string): void {
    [this.wish, this.good, this.keeping] = [null, [], false];
    [this.nudged, this.turned] = [[0, 0], 0];
    this.shown = "";
    this.rest(note);
    const { later } = this;
    this.later = null;
    if (later) this.follow(later.wish);
    if (later?.keep) void this.keep();
  }

  /** Show what is selected as the text has it, with what is left to say of how it came to that. */
  private rest(left = ""): void {
    const { subject } = this;
    const { path, text } = this.editor.document;
    if (this.busy) return;
    const key = subject ? JSON.stringify([path, subject.path, this.look, text]) : "";
    if (key === this.shown) return;
    [this.shown, this.left] = [key, left];
    const owner = subject ? keyOf(subject.path) : "";
    if (owner !== this.owner) this.show(null, "");
    this.owner = owner;
    if (subject) void this.ask({});
  }

  private show(pose: Pose | null, note: string): void {
    [this.pose, this.note] = [pose, note];
    this.changed.emit();
  }

  private async answer(wish: PoseWish): Promise<void> {
    const { subject, editor } = this;
    const { path, text } = editor.document;
    if (!subject || path === null) return;
    const [list, index] = subject.path as ["mechanisms" | "people", number];
    try {
      const pose = await editor.studio.api.pose({ path, text, item: [list, index], look: this.look, ...wish });
      if (this.subject !== null && keyOf(this.subject.path) !== keyOf(subject.path)) return;
      this.answered = wish;
      this.take(pose, wish);
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      this.answered = wish;
      this.show(this.pose, error.message);
    }
  }

  private take(pose: Pose, wish: PoseWish): void {
    if (this.busy && Object.keys(wish).length) {
      this.good = pose.changes;
      const ghosts = pose.items.flatMap((place) => {
        const item = this.editor.document.itemAt(place.path);
        return item ? [{ ...item, ...place }] : [];
      });
      this.editor.preview(ghosts.map((ghost, k) => ({ ghost, changes: k ? [] : pose.changes })));
    }
    const resting = Object.keys(wish).length === 0;
    if (resting) this.resting = pose;
    this.show(pose, resting ? this.left : pose.note);
  }
}

/** The middle of each outline of an item. */
function middles(item: Item): Point[] {
  return item.polygons.map((polygon) => {
    const sum = polygon.reduce<Point>((total, [x, y]) => [total[0] + x, total[1] + y], [0, 0]);
    return [sum[0] / Math.max(polygon.length, 1), sum[1] / Math.max(polygon.length, 1)];
  });
}
