/** What is done to the world in the Edit view, whether by mouse, by keys or by a button. */

import type { Change, Item, Path, Point, Values } from "../api";
import { keyOf, type Plan } from "../plan/plan";
import type { Look } from "../plan/shapes";
import type { Studio } from "../shell/view";
import { debounced, Signal } from "../ui/signal";
import { word } from "../words/words";
import { type Arrangement, arranged } from "./arrange";
import { type Piece, written } from "./clipboard";
import { asWritten, copied, freshName, remarked, renamed } from "./copies";
import { following } from "./follow";
import { forgetting, withMounted } from "./gone";
import { byThemselves, grouped, regrouped, turnedAlike, ungrouped, withGroups } from "./groups";
import { picturesAlong, withPictures } from "./hung";
import { Poser } from "./poser";
import { type Changed, isJoint, moved } from "./shapes";

export class Editor {
  /** Items as a drag has them now; empty when it is over. */
  readonly dragged = new Signal<Item[]>();
  /** The fields of what is selected are wanted. */
  readonly asked = new Signal();
  /** Whether each thing that is touched is added to the selection, as with Shift. */
  adding = false;
  /** What is to be read out to who does not see the plan. */
  readonly said = new Signal<string>();
  /** Poses of mechanisms and people. */
  readonly poser: Poser;
  private hovered: string | null = null;
  private steps: { key: string; count: number; items: Item[]; make(items: Item[], steps: number): Changed[] } | null =
    null;
  private readonly onTheWay = new Map<string, Item>();
  private readonly write = debounced(() => this.writeSteps(), 200);
  /** What was copied or pasted last, and how often that was pasted since. */
  private clip = { text: "", pasted: 0 };
  /** The end of the queue of things that are added. */
  private putIn: Promise<unknown> = Promise.resolve();

  constructor(
    readonly studio: Studio,
    readonly plan: Plan,
  ) {
    const { document } = studio;
    this.poser = new Poser(this);
    document.opened.on(() => (plan.forgetView(), this.onTheWay.clear()));
    document.parsedChanged.on(() => this.show());
    document.selectionChanged.on(() => this.look());
    document.finishing.on(() => this.write.now());
  }

  get document(): Studio["document"] {
    return this.studio.document;
  }

  get items(): Item[] {
    return this.document.items;
  }

  get selected(): Item[] {
    return this.document.selectedItems.map((item) => this.asDrawn(item));
  }

  select(items: Item[]): void {
    this.document.select(items.map((item) => item.path));
    const [first] = items;
    if (items.length === 1 && first) this.said.emit(described(first));
    else if (items.length > 1) this.said.emit(word("edit.thingsSelected", { items: items.length }));
  }

  /** Select things with the groups that they are of. */
  pick(items: Item[]): void {
    this.select(withGroups(items, this.items));
  }

  hover(item: Item | null): void {
    const key = item ? keyOf(item.path) : null;
    if (key === this.hovered) return;
    this.hovered = key;
    this.look();
  }

  /** Show items as a drag has them, without changing the text yet. */
  preview(changed: Changed[]): void {
    this.plan.ghost(changed.map(({ ghost }) => ghost));
    this.document.sketch(changed.flatMap(({ changes }) => changes));
    this.dragged.emit(changed.map(({ ghost }) => ghost));
  }

  /** Give up what was dragged. */
  forget(): void {
    this.plan.ghost([]);
    this.document.sketch([]);
    this.dragged.emit([]);
  }

  /** Write changes into the text; the plan shows them when the server has read it. */
  async apply(changes: Change[]): Promise<boolean> {
    // Steps that are still put together come first: these changes may take away what they are about.
    this.write.now();
    const done = await this.document.change(changes);
    if (!done) this.forget();
    return done;
  }

  /** Write what things were made by a drag or by keys; until the server has read it, they are taken as they are drawn. */
  async commit(changed: Changed[]): Promise<void> {
    for (const { ghost } of changed) this.onTheWay.set(keyOf(ghost.path), ghost);
    await this.apply(changed.flatMap(({ changes }) => changes));
    for (const { ghost } of changed) if (this.asDrawn(ghost) === ghost) this.onTheWay.delete(keyOf(ghost.path));
    this.showOnTheWay();
  }

  /** Show what is still on its way, unless something is dragged. */
  private showOnTheWay(): void {
    if (this.steps || this.plan.dragging) return;
    this.plan.ghost(this.onTheWay.values());
    if (this.onTheWay.size === 0) this.dragged.emit([]);
  }

  /** What goes with a change of a field: what is called by a name follows it, pictures follow their wall. */
  alongWith(change: Change): Change[] {
    return [...following(change, this.document), ...this.hungOn(change)];
  }

  /** The pictures on a wall whose corners are set. */
  private hungOn(change: Change): Change[] {
    const wall = this.document.itemAt(change.path.slice(0, 2));
    return change.op === "set" && wall ? picturesAlong(wall, change.path.slice(2), change.value, this.drawn) : [];
  }

  /** Append a new item to a list and select it, under a name and a marker that no item added before it has. */
  async add(list: Path, item: Values): Promise<void> {
    await this.inTurn(async () => {
      const value = renamed(remarked(item, this.items), this.names());
      if (!(await this.apply([{ op: "add", path: list, value }]))) return;
      const last = this.inList(list).at(-1);
      if (last) this.select([last]);
    });
  }

  /** Add things after all that were asked for earlier. */
  private inTurn(work: () => Promise<void>): Promise<void> {
    const done = this.putIn.then(() => this.document.settled()).then(work);
    this.putIn = done.catch(() => undefined); // the caller handles its own errors
    return done;
  }

  /** Those of some items that can be changed here; says why when one cannot. */
  free(items: Item[]): Item[] {
    const held = items.find((item) => item.fixed);
    if (held?.fixed) this.studio.toasts.error(`${held.label}: ${held.fixed}`);
    return items.filter((item) => !item.fixed);
  }

  /** Shift what is selected. Steps that follow each other quickly are one change, shown at once. */
  nudge(by: Point): void {
    if (this.poser.nudge(by)) return;
    const shift = (item: Item, steps: number): Changed => moved(item, [by[0] * steps, by[1] * steps], this.drawn);
    this.step("shift", (items, steps) => byThemselves(items).map((item) => shift(item, steps)), JSON.stringify(by));
  }

  /** Turn what is selected, each thing and each group about its own middle. */
  turn(degrees: number): void {
    if (this.poser.turn(degrees)) return;
    this.step("turn", (items, steps) => turnedAlike(items, degrees * steps, this.drawn), String(degrees));
  }

  /** Do a small change once more: it is written when no more come. */
  private step(kind: string, make: (items: Item[], steps: number) => Changed[], size: string): void {
    const key = `${kind} ${size} ${JSON.stringify(this.document.selection)}`;
    if (this.steps && this.steps.key !== key) this.write.now();
    if (!this.steps)
      this.steps = { key, count: 0, make, items: this.free(this.selected).map((item) => this.asDrawn(item)) };
    this.steps.count++;
    this.preview(this.stepped());
    this.write();
  }

  private stepped(): Changed[] {
    const { steps } = this;
    return steps ? withPictures(steps.make(steps.items, steps.count), this.drawn) : [];
  }

  /** All items as the changes that are still on their way will make them. */
  private get drawn(): Item[] {
    return this.onTheWay.size ? this.items.map((item) => this.asDrawn(item)) : this.items;
  }

  /** An item as the last change that is still on its way will make it. */
  private asDrawn(item: Item): Item {
    return this.onTheWay.get(keyOf(item.path)) ?? item;
  }

  async remove(): Promise<void> {
    // Just after an undo, what is selected may be there no more.
    await this.document.settled();
    const items = this.free(this.selected);
    // From the last to the first, so that the places of the others hold; what lies within another goes with it.
    const keys = new Set(items.map(({ path }) => keyOf(path)));
    const isPart = ({ path }: Item): boolean => path.some((_, count) => count && keys.has(keyOf(path.slice(0, count))));
    const whole = items.filter((item) => !isPart(item));
    const gone = withMounted(whole, this.items).sort((a, b) => comparePaths(b.path, a.path));
    const along = forgetting(gone, this.document);
    this.document.select([]);
    void this.apply([...along, ...gone.map(({ path }): Change => ({ op: "remove", path }))]);
    if (whole.length) this.said.emit(word("edit.deleted", { things: counted(whole) }));
    const more = along.length + gone.length - whole.length;
    if (more) this.studio.toasts.done(word("edit.deletedWith", { things: counted(whole), more }));
  }

  /** Return what is selected as text of a world, to be put on the clipboard; empty when nothing can be copied. */
  copy(): string {
    const pieces = this.pieces();
    this.clip = { text: written(pieces), pasted: 0 };
    if (pieces.length)
      this.said.emit(
        word("edit.copied", {
          things:
            pieces.length === 1 ? counted(this.selected.slice(0, 1)) : word("edit.things2", { count: pieces.length }),
        }),
      );
    return this.clip.text;
  }

  /** Put in the things of a text; without one those that were copied here. Pasted again, they go on in one direction. */
  async paste(text = this.clip.text): Promise<void> {
    if (text !== this.clip.text) this.clip = { text, pasted: 0 };
    const times = ++this.clip.pasted;
    try {
      const { items } = await this.studio.api.items(text);
      await this.inTurn(() => this.insert(items, times));
    } catch (error) {
      this.studio.toasts.error(error);
    }
  }

  duplicate(): void {
    // Read the selection in turn, so that a second Ctrl+D copies the first copy.
    void this.inTurn(() => this.insert(this.pieces(), 1));
  }

  private pieces(): Piece[] {
    const items = this.selected.filter((item) => item.type !== "Opening" && !isJoint(item));
    return items.map((item) => ({ list: String(item.path[0]), value: asWritten(item) }));
  }

  /** Write what is selected, as far as it is repeated or included, as items of the text's own, alone or with all repetitions. */
  makeSingle(op: "apart" | "single" = "apart"): void {
    const foreign = this.selected.filter((item) => item.origin);
    void this.apply(foreign.map(({ path }): Change => ({ op, path })));
  }

  /** Align what is selected, or spread it evenly, as one change. */
  async arrange(how: Arrangement): Promise<void> {
    // Things may still be where the text before had them.
    await this.document.settled();
    const changed = withPictures(arranged(this.free(this.selected), how, this.items), this.items);
    await this.apply(changed.flatMap(({ changes }) => changes));
  }

  /** Make what is selected one group, or take it out of its groups. */
  async group(together: boolean): Promise<void> {
    await this.document.settled();
    const changes = together ? grouped(this.free(this.selected), this.items) : ungrouped(this.selected);
    if (changes.length > (together ? 1 : 0)) await this.apply(changes);
  }

  selectAll(): void {
    this.select(this.items.filter((item) => item.type !== "Opening"));
  }

  /** The next item in the order of the text; null at the end. */
  next(step: 1 | -1): Item | null {
    const items = [...this.items].sort((a, b) => a.line - b.line || comparePaths(a.path, b.path));
    const [first] = this.document.selection;
    const now = first ? items.findIndex((item) => keyOf(item.path) === keyOf(first)) : step === 1 ? -1 : items.length;
    return items[now + step] ?? null;
  }

  private writeSteps(): void {
    const changed = this.stepped();
    this.steps = null;
    void this.commit(changed);
  }

  /** A name that nothing has yet: as wished, or with a number. */
  freshName(wish: string): string {
    return freshName(wish, this.names());
  }

  private get shift(): Point {
    const step = Math.max(this.plan.step * 5, this.plan.px(24));
    return [Number(step.toFixed(1)), -Number(step.toFixed(1))];
  }

  /** Put in things under names of their own, so many steps beside where they were. */
  private async insert(pieces: Piece[], steps: number): Promise<void> {
    if (pieces.length === 0) return;
    const by: Point = [this.shift[0] * steps, this.shift[1] * steps];
    const values = copied(
      regrouped(
        pieces.map(({ value }) => value),
        this.items,
      ),
      by,
      this.names(),
    );
    const changes = pieces.map(({ list }, index): Change => {
      return { op: "add", path: list === "floor" ? ["floor", "patches"] : [list], value: values[index] };
    });
    if (!(await this.apply(changes))) return;
    const lists = [...new Set(changes.map((change) => keyOf(change.path)))];
    const added = lists.flatMap((key) => {
      const path = JSON.parse(key) as Path;
      return this.inList(path).slice(-changes.filter((change) => keyOf(change.path) === key).length);
    });
    this.select(added);
  }

  private names(): Set<string> {
    return new Set(this.items.map((item) => item.name).filter((name) => name !== null));
  }

  private inList(list: Path): Item[] {
    const found = this.items.filter((item) => item.path.length === list.length + 1 && isWithin(item.path, list));
    return found.filter((item) => !item.fixed).sort((a, b) => comparePaths(a.path, b.path));
  }

  private show(): void {
    const { items, parsed } = this.document;
    this.showOnTheWay();
    this.look();
    this.plan.setItems(items, parsed.bounds);
  }

  private look(): void {
    const looks = new Map<string, Look>();
    const put = (key: string, look: Look): void => void looks.set(key, { ...looks.get(key), ...look });
    for (const problem of this.document.parsed.problems) {
      const item = itemOf(problem.path, this.items);
      if (item) put(keyOf(item.path), { problem: problem.kind });
    }
    for (const { path, origin } of this.items) if (origin) put(keyOf(path), { origin });
    if (this.hovered) put(this.hovered, { hovered: true });
    for (const path of this.document.selection) put(keyOf(path), { selected: true });
    this.plan.looks = looks;
    this.plan.refresh();
  }
}

/** The innermost item that a path of the text lies in. */
export function itemOf(path: Path | null, items: Item[]): Item | null {
  if (!path) return null;
  const around = items.filter((item) => isWithin(path, item.path) || keyOf(path) === keyOf(item.path));
  return around.sort((a, b) => b.path.length - a.path.length)[0] ?? null;
}

export function isWithin(path: Path, outer: Path): boolean {
  return path.length > outer.length && outer.every((key, index) => key === path[index]);
}

/** The name of one thing, the number of several. */
function counted(items: Item[]): string {
  return items.length === 1 && items[0] ? items[0].label : word("edit.things2", { count: items.length });
}

/** A sentence about an item, for who hears the plan. */
export function described(item: Item): string {
  const place = item.at?.map((value) => value.toFixed(2)).join(", ");
  const name = place ? word("edit.thingAt", { name: item.label, place }) : item.label;
  const facing = item.heading_deg !== null && item.type !== "Opening" ? `, ${Math.round(item.heading_deg)}°` : "";
  const held = item.fixed ? `; ${item.fixed}` : "";
  return `${name}${facing}${held}`;
}

function comparePaths(a: Path, b: Path): number {
  for (let k = 0; k < Math.min(a.length, b.length); k++) {
    const [one, other] = [a[k], b[k]];
    if (one === other) continue;
    return typeof one === "number" && typeof other === "number" ? one - other : String(one) < String(other) ? -1 : 1;
  }
  return a.length - b.length;
}
