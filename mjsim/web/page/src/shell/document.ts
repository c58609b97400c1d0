/** The world that is open: its text, all texts before, what the server reads from it, what is selected. */

import {
  type Api,
  ApiError,
  type Change,
  type Edited,
  type Item,
  type Opened,
  type Parsed,
  type Past,
  type Path,
} from "../api";
import { isWindow } from "../plan/geometry";
import { difference } from "../text/difference";
import { debounced, newestWins, Signal } from "../ui/signal";
import { said, word, wordFor } from "../words/words";
import { History } from "./history";
import { named } from "./naming";

const EMPTY: Parsed = { problems: [], items: [], bounds: [0, 0, 10, 8], name: "", run: {}, needs_trust: {}, files: {} };
/** Typing is read after so long a pause [ms]. */
const PAUSE = 250;
/** Letters typed within so long are one step of undo [ms]. */
const STROKE = 1000;

export type Origin = "open" | "type" | "edit" | "history" | "draft";

export class WorldDocument {
  path: string | null = null;
  parsed: Parsed = EMPTY;
  private there: Item[] = [];
  /** Items by the key of their path. */
  private places = new Map<string, Item>();
  stamp: string | null = null;
  selection: Path[] = [];
  /** Another world was opened. */
  readonly opened = new Signal();
  readonly textChanged = new Signal<Origin>();
  readonly parsedChanged = new Signal();
  readonly selectionChanged = new Signal();
  /** Saved, or no longer as saved. */
  readonly stateChanged = new Signal();
  /** Before a step is taken back, or the text is saved: what is still put together is to be written now. */
  readonly finishing = new Signal();
  /** What a call to the server could not do. */
  readonly failed = new Signal<unknown>();
  /** The text as a drag would make it; null when there is none. */
  private draft: string | null = null;
  private readonly askDraft = newestWins((changes: Change[]) => this.readDraft(changes));
  private saved = "";
  /** Whether its file was removed from disk since it was read. */
  private gone = false;
  private history = new History();
  private typedAt = 0;
  private asked = 0;
  private work: Promise<unknown> = Promise.resolve();
  private reading: Promise<void> = Promise.resolve();
  /** Whether a drag goes on whose text is to be shown. */
  private sketched = false;
  private isNew = false;
  /** Changes that are on their way. */
  private pending = 0;
  /** Counts the texts that were read from disk: a change of an earlier one is none of this. */
  private edition = 0;
  private readonly readSoon = debounced(() => void this.read(), PAUSE);

  constructor(private readonly api: Api) {}

  /** Those of the last text that could be read. */
  get items(): Item[] {
    return this.there;
  }

  private set items(items: Item[]) {
    this.there = items;
    this.places = new Map(items.map((item) => [JSON.stringify(item.path), item]));
  }

  get text(): string {
    return this.history.text;
  }

  /** The text as it is shown: while a drag goes on, as it would be. */
  get shown(): string {
    return this.draft ?? this.text;
  }

  /** Show what changes would make of the text, without making them; nothing goes back to the text as it is. */
  sketch(changes: Change[]): void {
    this.sketched = changes.length > 0;
    if (this.sketched) this.askDraft(changes);
    else this.dropDraft();
  }

  private async readDraft(changes: Change[]): Promise<void> {
    const { path, text } = this;
    if (path === null || !this.sketched) return;
    try {
      const { text: draft } = await this.api.edit(path, text, changes);
      if (!this.sketched || this.text !== text) return;
      this.draft = draft;
      this.textChanged.emit("draft");
    } catch {
      // What cannot be written is told when the drag ends.
    }
  }

  private dropDraft(): void {
    this.sketched = false;
    if (this.draft === null) return;
    this.draft = null;
    this.textChanged.emit("draft");
  }

  get isOpen(): boolean {
    return this.path !== null;
  }

  /** Whether it would be lost with the page: edited, or its file is gone. */
  get isChanged(): boolean {
    return this.isEdited || (this.isOpen && this.gone);
  }

  /** Whether the text is another than the one that was read or saved. */
  get isEdited(): boolean {
    return this.isOpen && this.text !== this.saved;
  }

  /** Whether a drag goes on, or a change is on its way. */
  get isBusy(): boolean {
    return this.sketched || this.pending > 0;
  }

  /** Whether it needs a name before it can be saved: new, or one that came with mjsim. */
  get needsName(): boolean {
    return this.path === null || this.path === "" || this.path.startsWith("shipped:") || this.isNew;
  }

  /** Whether its path names a file: of the folder, or one that came with mjsim. */
  get hasFile(): boolean {
    return this.path !== null && (!this.needsName || this.path.startsWith("shipped:"));
  }

  /** Take up a world as the server gave it. */
  take(world: Opened, isNew = false): void {
    this.path = world.path;
    this.history = new History(world.text);
    this.stamp = world.stamp ?? null;
    this.saved = world.text;
    [this.isNew, this.gone] = [isNew, false];
    this.typedAt = 0;
    this.edition++;
    this.selection = [];
    this.items = [];
    this.asked++;
    this.opened.emit();
    this.textChanged.emit("open");
    this.stateChanged.emit();
    this.adopt(world);
    this.selectionChanged.emit();
  }

  /** The steps that lead to the text and on from it. */
  get past(): Past {
    return this.history.past();
  }

  /** Put a text that was kept in the place of all of it: with the steps that led to it, or as one over other changes. */
  async restore(text: string, past: Past): Promise<void> {
    this.typedAt = 0;
    [this.draft, this.sketched] = [null, false];
    if (this.isEdited) this.history.push(text, false, word("step.restore"));
    else this.history.restore(text, past);
    this.textChanged.emit("edit");
    this.stateChanged.emit();
    await this.read();
  }

  /** Take the text that its file has now in place of its own, as one step of undo. */
  reload(world: Opened): void {
    const chosen = this.selectedItems;
    this.rebase(world);
    this.typedAt = 0;
    this.asked++;
    this.edition++;
    this.push(world.text, false, word("step.load"));
    this.textChanged.emit("edit");
    this.stateChanged.emit();
    this.adopt(world);
    // What stands at the same place of another text may be another thing.
    this.select(chosen.filter((item) => this.itemAt(item.path)?.label === item.label).map(({ path }) => path));
  }

  /** Keep the text as it is, as a change of what its file has now. */
  rebase({ text, stamp }: Opened): void {
    [this.saved, this.stamp, this.gone] = [text, stamp, false];
    this.stateChanged.emit();
  }

  /** Its file was removed from disk, or is there again as it was. */
  noteGone(gone: boolean): void {
    if (this.gone === gone) return;
    this.gone = gone;
    this.stateChanged.emit();
  }

  /** The person typed: read it after a pause. */
  type(text: string): void {
    if (text === this.text) return;
    const now = Date.now();
    const goesOn = now - this.typedAt < STROKE && this.canUndo;
    this.typedAt = now;
    this.push(text, goesOn, word("step.type", { line: lineOfChange(this.text, text) }));
    this.textChanged.emit("type");
    this.stateChanged.emit();
    this.readSoon();
  }

  /** Change the text through the server, as one step of undo; done one after the other. False: it was refused. */
  async change(changes: Change[]): Promise<boolean> {
    if (changes.length === 0 || this.path === null) return false;
    const { edition } = this;
    this.pending++;
    const done = this.work.then(() => this.changeNow(changes, edition)).finally(() => this.pending--);
    this.work = done;
    return done;
  }

  private async changeNow(changes: Change[], edition: number): Promise<boolean> {
    const { path, text } = this;
    let edited: Edited;
    try {
      edited = await this.ofEdition(edition, () => this.api.edit(path ?? "", text, changes));
    } catch (error) {
      this.failed.emit(error);
      this.dropDraft();
      this.parsedChanged.emit(); // what was dragged goes back to where it is
      return false;
    }
    if (this.text !== text) {
      // Somebody typed meanwhile: the change is of another text.
      this.failed.emit(new ApiError(409, word("step.wasTyped")));
      this.parsedChanged.emit();
      return false;
    }
    this.asked++;
    this.typedAt = 0;
    this.push(
      edited.text,
      false,
      named(changes, (at) => this.itemAround(at)),
    );
    this.textChanged.emit("edit");
    this.stateChanged.emit();
    this.noteRaw(changes);
    this.adopt(edited);
    return true;
  }

  /** Do what belongs to the text as it was read from disk, if it has not been read again meanwhile. */
  private async ofEdition<T>(edition: number, work: () => Promise<T>): Promise<T> {
    const done = edition === this.edition ? await work() : null;
    if (done !== null && edition === this.edition) return done;
    throw new ApiError(409, word("step.wasReloaded"));
  }

  /** What was set stands in the text, be it right or wrong. */
  private noteRaw(changes: Change[]): void {
    for (const change of changes) {
      if (change.op !== "set") continue;
      const item = this.items.find((other) => isIn(change.path, other.path));
      const [key, ...deeper] = change.path.slice(item?.path.length);
      if (!item?.raw || typeof key !== "string" || deeper.length) continue;
      item.raw = { ...item.raw, [key]: change.value };
      item.written = [...new Set([...item.written, key])];
    }
  }

  get canUndo(): boolean {
    return this.history.canUndo;
  }

  get canRedo(): boolean {
    return this.history.canRedo;
  }

  async undo(): Promise<void> {
    await this.finish();
    if (this.canUndo) this.go(this.steps.at - 1);
  }

  async redo(): Promise<void> {
    await this.finish();
    if (this.canRedo) this.go(this.steps.at + 1);
  }

  /** What each step of undo did, the oldest first, and how many of them lead to the text. */
  get steps(): { names: string[]; at: number } {
    return this.history.told;
  }

  /** Go to the text after so many of the steps. */
  async goTo(count: number): Promise<void> {
    await this.finish();
    if (count !== this.steps.at) this.go(count);
  }

  /** Wait until what is under way is a step of its own. */
  private async finish(): Promise<void> {
    this.finishing.emit();
    await this.work;
  }

  select(paths: Path[]): void {
    const same = JSON.stringify(paths) === JSON.stringify(this.selection);
    this.selection = paths;
    if (!same) this.selectionChanged.emit();
  }

  itemAt(path: Path): Item | null {
    return this.places.get(JSON.stringify(path)) ?? null;
  }

  get selectedItems(): Item[] {
    return this.selection.map((path) => this.itemAt(path)).filter((item) => item !== null);
  }

  /** It was saved: under this path, with this stamp. */
  noteSaved(path: string, stamp: string, text: string): void {
    Object.assign(this, { path, stamp, saved: text, isNew: false, gone: false });
    this.stateChanged.emit();
  }

  /** Wait until all edits asked for are in the text, and what was typed is read. */
  async settled(): Promise<void> {
    this.readSoon.now();
    await this.finish();
    await this.reading;
  }

  /** Have the server read the text as it is now. */
  read(): Promise<void> {
    this.reading = this.readNow();
    return this.reading;
  }

  private async readNow(): Promise<void> {
    if (this.path === null) return;
    const mine = ++this.asked;
    try {
      const parsed = await this.api.parse(this.path, this.text);
      if (mine === this.asked) this.adopt(parsed);
    } catch (error) {
      this.failed.emit(error);
    }
  }

  /** Items that are wrong now are no longer given: they stay as they were, so that one sees which they are. */
  private broken(parsed: Parsed): Item[] {
    const there = new Set(parsed.items?.map((item) => JSON.stringify(item.path)));
    const wrong = parsed.problems.flatMap(({ path }) => (path ? [path] : []));
    return this.items.filter(
      (item) => !there.has(JSON.stringify(item.path)) && wrong.some((path) => isIn(path, item.path)),
    );
  }

  private push(text: string, joined: boolean, what: string): void {
    [this.draft, this.sketched] = [null, false];
    this.history.push(text, joined, what);
  }

  /** The innermost item at or around a path. */
  private itemAround(path: Path): Item | null {
    const item = this.itemAt(path);
    return item || path.length === 0 ? item : this.itemAround(path.slice(0, -1));
  }

  private go(count: number): void {
    [this.draft, this.sketched] = [null, false];
    this.history.goTo(count);
    this.typedAt = 0;
    this.textChanged.emit("history");
    this.stateChanged.emit();
    void this.read();
  }

  private adopt(parsed: Parsed): void {
    this.parsed = parsed;
    if (parsed.items) this.items = [...parsed.items.map(labelled), ...this.broken(parsed)];
    const kept = this.selection.filter((path) => this.itemAt(path) !== null);
    const lost = kept.length !== this.selection.length;
    this.selection = kept;
    this.parsedChanged.emit();
    if (lost) this.selectionChanged.emit();
  }
}

/** A thing without a name, called by its kind and its number in the language of the page. */
function labelled(item: Item): Item {
  const number = Number(item.path.at(-1)) + 1;
  const fixed = item.fixed && said(item.fixed);
  return item.name === null
    ? { ...item, fixed, label: wordFor("item", isWindow(item) ? "window" : item.kind, { number }) }
    : { ...item, fixed };
}

/** The line in which two texts begin to differ, counted from 1. */
function lineOfChange(old: string, fresh: string): number {
  return fresh.slice(0, difference(old, fresh).from).split("\n").length;
}

function isIn(path: Path, outer: Path): boolean {
  return path.length >= outer.length && outer.every((key, index) => key === path[index]);
}
