/** What a run begins with: the same form as in Edit, for settings that the world need not keep, and a file to record to. */

import type { Change, Problem, Values } from "../api";
import { applied, differences, isSame } from "../panel/changes";
import { driverRows, type RunValues, suggestion } from "../panel/driver";
import { ModuleShelf } from "../panel/modules";
import { objectRows, type Sheet } from "../panel/rows";
import { SchemaBook } from "../panel/schema";
import { toolsFor } from "../panel/tools";
import type { Studio } from "../shell/view";
import { type Child, el, refill } from "../ui/dom";
import { word } from "../words/words";

/** What is set elsewhere: drivers have forms of their own, events are what the plan is touched for. */
const ELSEWHERE = ["view", "drivers", "events"];

export class Setup {
  readonly element = el("div", { class: "run-setup" });
  private readonly record = el("input", { type: "checkbox" });
  private readonly file = el("input", { type: "text", "aria-label": word("run.fileToRecordTo"), spellcheck: "false" });
  private readonly form = el("div", {});
  private readonly open = new Map<string, boolean>();
  private book: SchemaBook | null = null;
  private shelf: ModuleShelf | null = null;
  private loading: Promise<void> | null = null;
  /** What is to be other than in the world. */
  private changes: Change[] = [];
  private problems: Problem[] | null = null;
  private asked = 0;

  constructor(private readonly studio: Studio) {
    this.file.disabled = true;
    this.record.addEventListener("change", () => (this.file.disabled = !this.record.checked));
    this.element.append(
      this.form,
      el("h2", {}, word("run.recording")),
      el("label", { class: "run-check" }, this.record, word("run.recordToAFile")),
      el("label", { class: "run-field" }, el("span", {}, word("run.file")), this.file),
    );
    studio.document.opened.on(() => this.discard());
  }

  /** Take up the world as it is now. */
  world(): void {
    this.file.placeholder = `out/${this.studio.document.parsed.name || "world"}/run.mcap`;
    const { raw } = this.run(false);
    // What the world has by now is no change of it.
    this.changes = this.changes.filter((change) => !isSame(applied(raw, [within(change)]), raw));
    void this.loaded().then(() => this.draw());
  }

  /** The order to start says where to record. */
  recording(): { record?: string } {
    return this.record.checked ? { record: this.file.value.trim() || this.file.placeholder } : {};
  }

  /** A text of the world with these settings in it. */
  async put(path: string, text: string): Promise<string> {
    return this.changes.length ? (await this.studio.api.edit(path, text, this.changes)).text : text;
  }

  /** The forms: asked for once, and anew where there was no answer. */
  private loaded(): Promise<void> {
    return (this.loading ??= this.load());
  }

  private async load(): Promise<void> {
    try {
      this.book = new SchemaBook(await this.studio.api.schema());
    } finally {
      if (!this.book) this.loading = null;
    }
    this.shelf = new ModuleShelf(this.studio, this.book);
    this.shelf.changed.on(() => this.draw());
  }

  private draw(): void {
    const { book, shelf } = this;
    const { document } = this.studio;
    if (!book || !shelf || !document.isOpen) return;
    const run = this.run(true);
    const sheet: Sheet = {
      book,
      tools: toolsFor(this.studio, shelf),
      problems: this.problems ?? document.parsed.problems,
      open: this.open,
      change: (changes) => this.change(changes),
    };
    const robots = document.items.filter((item) => item.type === "Robot");
    const parts = robots.flatMap((robot) => [
      el("h2", {}, robot.name ?? robot.label),
      suggestion(sheet, shelf, robot, run, document.items),
      ...driverRows(sheet, robot, run),
    ]);
    refill(this.form, this.state(), ...this.settings(sheet, run), ...parts);
  }

  private settings(sheet: Sheet, { values, raw }: RunValues): Child[] {
    const schema = sheet.book.definition("Run");
    const subject = { path: ["run"], values, raw, fixed: false };
    return schema ? objectRows(sheet, schema, subject, ELSEWHERE) : [];
  }

  /** Whether the world has all this, with buttons that make it so. */
  private state(): HTMLElement {
    const count = this.changes.length;
    if (!count) return el("p", { class: "hint" }, word("run.changesTakeEffectWithThe"));
    const keep = el(
      "button",
      { class: "primary", type: "button", "data-id": "keep", onclick: () => void this.keep() },
      word("run.keepInTheWorld"),
    );
    const discard = el(
      "button",
      { type: "button", "data-id": "discard", onclick: () => (this.discard(), this.draw()) },
      word("run.discardChanges"),
    );
    return el(
      "div",
      { class: "run-unkept", role: "status" },
      el("p", {}, word("run.notInTheWorld", { count })),
      el("div", {}, keep, discard),
    );
  }

  private change(changes: Change[]): void {
    const { raw } = this.run(false);
    const put = applied(applied(raw, this.inner()), changes.map(within));
    this.changes = differences(["run"], raw, put);
    this.draw();
    void this.check();
  }

  /** Learn from the server what is wrong with these settings. */
  private async check(): Promise<void> {
    const { path, text } = this.studio.document;
    const mine = ++this.asked;
    this.problems = null;
    if (path === null || this.changes.length === 0) return;
    try {
      const { problems } = await this.studio.api.edit(path, text, this.changes);
      if (mine !== this.asked) return;
      this.problems = problems;
      this.draw();
    } catch (error) {
      this.studio.toasts.error(error);
    }
  }

  /** Write the settings into the world, as one step of undo. */
  private async keep(): Promise<void> {
    const changes = this.changes;
    if (await this.studio.document.change(changes)) this.studio.toasts.done(word("run.keptInTheWorld"));
  }

  private discard(): void {
    [this.changes, this.problems] = [[], null];
    this.asked++;
  }

  /** What the world says of its run, with these settings in it or without. */
  private run(withChanges: boolean): RunValues {
    const { run, world } = this.studio.document.parsed;
    const raw = (world?.raw?.["run"] ?? {}) as Values;
    if (!withChanges) return { values: run, raw };
    return { values: applied(run, this.inner()) as Values, raw: applied(raw, this.inner()) as Values };
  }

  private inner(): Change[] {
    return this.changes.map(within);
  }
}

/** A change of a world as one of its run. */
function within(change: Change): Change {
  return { ...change, path: change.path.slice(1) } as Change;
}
