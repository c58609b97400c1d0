/** What a run begins with: the same form as in Edit, for settings that the world need not keep, and a file to record to. */

import type { Change, Problem, Values } from "../api";
import { applied, differences, isSame } from "../panel/changes";
import { driverRows, type RunValues, suggestion } from "../panel/driver";
import { ModuleShelf } from "../panel/modules";
import { objectRows, type Sheet } from "../panel/rows";
import { SchemaBook } from "../panel/schema";
import { toolsFor } from "../panel/tools";
import type { Studio } from "../shell/view";
import { el } from "../ui/dom";
import { draw, html, keyed, nothing, tickBox, type View, withValue } from "../ui/view";
import { word } from "../words/words";

/** What is set elsewhere: drivers have forms of their own, events are what the plan is touched for. */
const ELSEWHERE = ["view", "drivers", "events"];

export class Setup {
  readonly element = el("div", { class: "run-setup" });
  /** Whether to record, and the file to record to; "" for the one that is proposed. */
  private isRecording = false;
  private file = "";
  private readonly open = new Map<string, boolean>();
  private readonly refused = new Map<string, string>();
  private book: SchemaBook | null = null;
  private shelf: ModuleShelf | null = null;
  private loading: Promise<void> | null = null;
  /** What is to be other than in the world. */
  private changes: Change[] = [];
  private problems: Problem[] | null = null;
  private asked = 0;

  constructor(private readonly studio: Studio) {
    studio.document.opened.on(() => this.discard());
    this.draw();
  }

  /** Take up the world as it is now. */
  world(): void {
    const { raw } = this.run(false);
    // What the world has by now is no change of it.
    this.changes = this.changes.filter((change) => !isSame(applied(raw, [within(change)]), raw));
    void this.loaded().then(() => this.draw());
  }

  /** The order to start says where to record. */
  recording(): { record?: string } {
    return this.isRecording ? { record: this.file.trim() || this.proposed } : {};
  }

  private get proposed(): string {
    return `out/${this.studio.document.parsed.name || "world"}/run.mcap`;
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
    draw(this.element, html`<div>${keyed(this.studio.document.path, this.form())}</div>${this.recorder()}`);
  }

  private recorder(): View {
    const record = (on: boolean): void => {
      this.isRecording = on;
      this.draw();
    };
    const name = withValue((file) => (this.file = file));
    return html`<h2>${word("run.recording")}</h2>
      ${tickBox("run-check", word("run.recordToAFile"), this.isRecording, record)}
      <label class="run-field"><span>${word("run.file")}</span><input type="text" spellcheck="false" @input=${name}
        aria-label=${word("run.fileToRecordTo")} placeholder=${this.proposed} ?disabled=${!this.isRecording}></label>`;
  }

  private form(): View {
    const { book, shelf } = this;
    const { document } = this.studio;
    if (!book || !shelf || !document.isOpen) return nothing;
    const run = this.run(true);
    const sheet: Sheet = {
      book,
      tools: toolsFor(this.studio, shelf),
      problems: this.problems ?? document.parsed.problems,
      open: this.open,
      refused: this.refused,
      redraw: () => this.draw(),
      change: (changes) => this.change(changes),
    };
    const robots = document.items.filter((item) => item.type === "Robot");
    const parts = robots.map(
      (robot) => html`<h2>${robot.name ?? robot.label}</h2>${suggestion(sheet, shelf, robot, run, document.items)}
        ${driverRows(sheet, robot, run)}`,
    );
    return html`${this.state()}${this.settings(sheet, run)}${parts}`;
  }

  private settings(sheet: Sheet, { values, raw }: RunValues): View {
    const schema = sheet.book.definition("Run");
    return schema && objectRows(sheet, schema, { path: ["run"], values, raw, fixed: false }, ELSEWHERE);
  }

  /** Whether the world has all this, with buttons that make it so. */
  private state(): View {
    const count = this.changes.length;
    if (!count) return html`<p class="hint">${word("run.changesTakeEffectWithThe")}</p>`;
    return html`<div class="run-unkept" role="status"><p>${word("run.notInTheWorld", { count })}</p><div>
      <button class="primary" type="button" @click=${() => this.keep()}>${word("run.keepInTheWorld")}</button>
      <button type="button" @click=${() => (this.discard(), this.draw())}>${word("run.discardChanges")}</button></div></div>`;
  }

  private change(changes: Change[]): void {
    this.refused.clear();
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
    this.refused.clear();
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
