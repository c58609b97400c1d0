/** The panel of what is selected: every field of it, or of the world when nothing is. */

import type { Change, Item, Path, Problem, Values } from "../api";
import { ARRANGEMENTS, type Arrangement, arrangeable } from "../edit/arrange";
import { type Editor, itemOf } from "../edit/editor";
import { groupable, groupOf, wholeGroup } from "../edit/groups";
import { kindName } from "../edit/kinds";
import { keyOf } from "../plan/plan";
import { type Child, el, fill } from "../ui/dom";
import { icon } from "../ui/icons";
import { unpressed } from "../ui/press";
import { said, word } from "../words/words";
import type { Tools } from "./controls";
import { driverRows, type RunValues, suggestion } from "./driver";
import { ModuleShelf } from "./modules";
import { objectRows, type Sheet, type Subject } from "./rows";
import type { SchemaBook } from "./schema";
import { common, retold } from "./several";
import { toolsFor } from "./tools";

/** Keys of the world that have a plan of their own, and those that nobody needs to see. */
const LISTS = [
  ...["walls", "obstacles", "beacons", "robots", "lamps", "mechanisms", "people"],
  ...["mjsim", "include", "variables"],
];

/** Keys that each of several things has for itself. */
const OF_ONE = ["name", "at", "points", "openings", "sensors"];
const SINGLE = {
  repeat: word("panel.writeThisRepetitionAsAn"),
  include: word("panel.writeTheIncludedFileInto"),
};

export class Panel {
  readonly element = el("aside", { class: "panel", "aria-label": word("panel.properties") });
  private readonly body = el("div", { class: "panel-body" });
  private readonly open = new Map<string, boolean>();
  private readonly shelf: ModuleShelf;
  private readonly tools: Tools;
  private ghosts: Item[] = [];
  private due = false;

  constructor(
    private readonly editor: Editor,
    private readonly book: SchemaBook,
  ) {
    this.element.append(this.body);
    const { document } = editor;
    this.shelf = new ModuleShelf(editor.studio, book);
    this.tools = toolsFor(editor.studio, this.shelf);
    this.shelf.changed.on(() => this.soon());
    document.parsedChanged.on(() => this.soon());
    document.selectionChanged.on(() => {
      this.body.scrollTop = 0;
      this.soon();
    });
    editor.dragged.on((ghosts) => {
      this.ghosts = ghosts;
      this.soon();
    });
    this.draw();
  }

  /** Go to the first field, as Enter on the plan does. */
  focus(): void {
    const fields = ".value :is(input, select, button):not(:disabled), summary";
    this.body.querySelector<HTMLElement>(fields)?.focus();
  }

  /** Draw anew with the next picture, however often it was asked for. */
  private soon(): void {
    if (this.due) return;
    this.due = true;
    requestAnimationFrame(() => {
      this.due = false;
      unpressed(this.body, () => this.draw());
    });
  }

  private draw(): void {
    const { selected } = this.editor;
    const keep = this.keyboard();
    if (!this.editor.document.isOpen) fill(this.body, el("p", { class: "hint pad" }, word("panel.nothingIsOpenYet")));
    else if (selected.length === 0) this.drawWorld();
    else if (selected.length === 1 && selected[0]) this.drawItem(selected[0]);
    else this.drawMany(selected);
    keep();
  }

  private drawItem(selected: Item): void {
    const key = keyOf(selected.path);
    const ghost = this.ghosts.find((other) => keyOf(other.path) === key);
    const item = ghost ?? selected;
    const schema = this.book.definition(item.type);
    const subject = {
      path: item.path,
      values: item.values,
      raw: ghost ? undefined : item.raw,
      written: item.written,
      fixed: item.fixed !== null,
    };
    fill(
      this.body,
      this.head(kindName(item), item.name ?? item.label, this.buttons(item.type !== "Opening")),
      item.fixed ? this.origin(item, item.fixed) : null,
      item.type === "Robot" ? suggestion(this.sheet(), this.shelf, item, this.run(), this.editor.items) : null,
      ...this.general(item),
      ...(schema
        ? objectRows(this.sheet(), schema, subject, [], this.modules(item))
        : [el("p", { class: "hint pad" }, word("panel.editItInTheText"))]),
    );
  }

  /** Why an item cannot be changed here, and how it becomes one of the text's own. */
  private origin({ origin }: Item, why: string): Child {
    const press = origin ? { onclick: () => this.editor.makeSingle(), title: SINGLE[origin] } : null;
    const button = press && el("button", { ...press, "data-id": "single" }, word("panel.makeSingle"));
    return el("div", { class: "note" }, icon(origin ?? "lock"), el("span", {}, why), button);
  }

  /** Problems of the item that no row shows. */
  private general(item: Item): Child[] {
    const own = this.problems().filter((problem) => problem.path && keyOf(problem.path) === keyOf(item.path));
    return own.map((problem) => el("p", { class: `note ${problem.kind}` }, icon("warning"), said(problem.message)));
  }

  private drawWorld(): void {
    const { parsed } = this.editor.document;
    const schema = this.book.definition("");
    const loose = parsed.problems.filter(
      (problem) => !itemOf(problem.path, this.editor.items) && !this.isShown(problem),
    );
    const subject: Subject | null = parsed.world ? { path: [], ...given(parsed.world), fixed: false } : null;
    fill(
      this.body,
      this.head(word("panel.world"), parsed.name || "", []),
      ...loose.map((problem) =>
        el(
          "p",
          { class: `note ${problem.kind}` },
          icon("warning"),
          word("panel.line", { line: problem.line, message: said(problem.message) }),
        ),
      ),
      ...(schema && subject ? objectRows(this.sheet(), schema, subject, LISTS) : []),
      el("p", { class: "hint pad" }, word("panel.selectAThingOnThe")),
    );
  }

  private isShown(problem: Problem): boolean {
    const [key] = problem.path ?? [];
    const known = this.book.definition("")?.["properties"] as Values | undefined;
    return key !== undefined && known !== undefined && key in known && !LISTS.includes(String(key));
  }

  /** Several have the fields that all of them share; a change is made to all. */
  private drawMany(items: Item[]): void {
    const types = new Set(items.map((item) => item.type));
    const [first] = items;
    const group = wholeGroup(items, this.editor.items);
    const counted = group ?? word("panel.selected", { count: items.length });
    const kind = types.size === 1 && first ? kindName(first) : word("panel.severalThings");
    const title = group ? word("panel.groupOf", { count: items.length }) : kind;
    const rows: Child[] = [this.head(title, counted, this.buttons(true))];
    rows.push(this.arranger(items), this.grouper(items, group));
    const schema = this.book.shared([...types]);
    if (schema) rows.push(...objectRows(this.sheet(items), schema, common(items), OF_ONE));
    rows.push(el("p", { class: "hint pad" }, word("panel.dragThemTogetherTurnThem")));
    fill(this.body, ...rows);
  }

  /** Buttons that align things and spread them evenly. */
  private arranger(items: Item[]): Child {
    const count = arrangeable(items.filter((item) => !item.fixed)).length;
    if (count < 2) return null;
    const offered = (Object.keys(ARRANGEMENTS) as Arrangement[]).filter(
      (how) => count > 2 || !["across", "upright"].includes(how),
    );
    const buttons = offered.map((how) => {
      const title = ARRANGEMENTS[how];
      return el(
        "button",
        {
          class: "quiet square",
          title,
          "aria-label": title,
          "data-id": how,
          onclick: () => void this.editor.arrange(how),
        },
        icon(how),
      );
    });
    return el("div", { class: "arranger", role: "group", "aria-label": word("panel.alignAndDistribute") }, ...buttons);
  }

  /** Buttons that make things one group and take them out of theirs. */
  private grouper(items: Item[], whole: string | null): Child {
    const button = (text: string, together: boolean): HTMLElement => {
      const press = (): void => void this.editor.group(together);
      return el("button", { "data-id": together ? "group" : "ungroup", onclick: press }, text);
    };
    const own = groupable(items);
    return el(
      "div",
      { class: "grouper" },
      own.length > 1 && !whole ? button(word("edit.group"), true) : null,
      own.some(groupOf) ? button(word("edit.ungroup"), false) : null,
    );
  }

  private sheet(items: Item[] = []): Sheet {
    const change = (changes: Change[]): void => {
      const all = items.length ? items.flatMap((item) => changes.map((one) => retold(one, items[0], item))) : changes;
      void this.editor.apply([...all, ...all.flatMap((one) => this.editor.alongWith(one))]);
    };
    return { book: this.book, tools: this.tools, problems: this.problems(), open: this.open, change };
  }

  /** The modules of a robot, which stand in the run of the world. */
  private modules(item: Item): Child[] {
    if (item.type !== "Robot") return [];
    return [
      el(
        "div",
        { class: "modules" },
        el("h3", {}, word("panel.modules")),
        ...driverRows(this.sheet(), item, this.run()),
      ),
    ];
  }

  private run(): RunValues {
    const { run, world } = this.editor.document.parsed;
    return { values: run, raw: (world?.raw?.["run"] ?? {}) as Values };
  }

  private problems(): Problem[] {
    return this.editor.document.parsed.problems;
  }

  private head(kind: string, name: string, buttons: Child[]): HTMLElement {
    return el(
      "div",
      { class: "panel-head" },
      el("div", {}, el("span", { class: "kind" }, kind), el("h2", {}, name)),
      el("div", { class: "head-buttons" }, ...buttons),
    );
  }

  private buttons(copies: boolean): Child[] {
    const one = (name: "copy" | "trash", title: string, onclick: () => void): HTMLElement =>
      el("button", { class: "quiet square", title, "aria-label": title, onclick, "data-id": name }, icon(name));
    return [
      copies ? one("copy", word("panel.duplicateCtrlD"), () => this.editor.duplicate()) : null,
      one("trash", word("panel.deleteDel"), () => void this.editor.remove()),
    ];
  }

  /** Remember where the keyboard is, and what was typed and not given on; gives back how to restore it. */
  private keyboard(): () => void {
    const active = document.activeElement;
    if (!(active instanceof HTMLElement) || !this.body.contains(active)) return () => undefined;
    const id = active.dataset["id"];
    const byKeys = active.matches(":focus-visible");
    const typed = active instanceof HTMLInputElement ? typedIn(active) : null;
    const top = this.body.scrollTop;
    return () => {
      const again = this.control((other) => other === id) ?? (byKeys ? this.nextTo(id) : null);
      again?.focus({ preventScroll: true });
      if (typed && again instanceof HTMLInputElement && document.activeElement === again) keepTyped(again, typed);
      this.body.scrollTop = top;
    };
  }

  private control(isIt: (id: string) => boolean): HTMLElement | null {
    const all = [...this.body.querySelectorAll<HTMLElement>("[data-id]:not(:disabled)")];
    return all.find((other) => isIt(other.dataset["id"] ?? "")) ?? null;
  }

  /** Return what gets the focus of a control that is gone: its field, the group around it, or the plan. */
  private nextTo(id = ""): HTMLElement {
    const [key] = /^\[.*\]/.exec(id) ?? ["[]"];
    for (let path = JSON.parse(key) as Path; path.length; path = path.slice(0, -1)) {
      const found = this.control((other) => other === keyOf(path) || other.startsWith(`${keyOf(path)} `));
      if (found) return found;
    }
    return this.editor.plan.host;
  }
}

/** What a field holds that is not given on yet, null when it was not touched, and what is marked in it. */
interface Typed {
  text: string | null;
  marked: [number, number] | null;
}

/** Take what is typed from a field that is about to go: the browser would have it give half a number on. */
function typedIn(input: HTMLInputElement): Typed {
  const text = "touched" in input.dataset ? input.value : null;
  const [start, end] = [input.selectionStart, input.selectionEnd];
  input.dataset["replaced"] = "";
  return { text, marked: start === null || end === null ? null : [start, end] };
}

function keepTyped(input: HTMLInputElement, { text, marked }: Typed): void {
  if (input.type === "checkbox" || input.type === "color") return;
  if (text !== null && text !== input.value) {
    input.value = text;
    input.dataset["touched"] = "";
    giveOnLeaving(input);
  }
  if (marked) input.setSelectionRange(...marked);
}

/** Browsers tell of no change when a script has put the text in: tell of it when the field is left. */
function giveOnLeaving(input: HTMLInputElement): void {
  const told = new AbortController();
  input.addEventListener("change", () => told.abort());
  input.addEventListener("blur", () => input.dispatchEvent(new Event("change")), { signal: told.signal });
}

function given(world: { values: Values; written: string[]; raw?: Values }): {
  values: Values;
  written: string[];
  raw: unknown;
} {
  return { values: world.values, written: world.written, raw: world.raw };
}
