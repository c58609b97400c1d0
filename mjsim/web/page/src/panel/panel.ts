/** The panel of what is selected: every field of it, or of the world when nothing is. */

import type { Change, Item, Problem, Values } from "../api";
import { ARRANGEMENTS, type Arrangement, arrangeable } from "../edit/arrange";
import { type Editor, itemOf } from "../edit/editor";
import { groupable, groupOf, wholeGroup } from "../edit/groups";
import { kindName } from "../edit/kinds";
import { keyOf } from "../plan/plan";
import { el } from "../ui/dom";
import { iconButton, sign } from "../ui/icons";
import { draw, html, keyed, type View } from "../ui/view";
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
  private readonly refused = new Map<string, string>();
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
      this.refused.clear();
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
      this.draw();
    });
  }

  private draw(): void {
    const { selected } = this.editor;
    const [first, ...others] = selected;
    if (!this.editor.document.isOpen)
      return draw(this.body, html`<p class="hint pad">${word("panel.nothingIsOpenYet")}</p>`);
    const view = !first ? this.world() : others.length ? this.several(selected) : this.item(first);
    draw(this.body, keyed(selected.map(({ path }) => keyOf(path)).join(), view), this.editor.plan.host);
  }

  private item(selected: Item): View {
    const key = keyOf(selected.path);
    const ghost = this.ghosts.find((other) => keyOf(other.path) === key);
    const item = ghost ?? selected;
    const schema = this.book.definition(item.type);
    const { path, values, written } = item;
    const subject = { path, values, raw: ghost ? undefined : item.raw, written, fixed: item.fixed !== null };
    const isRobot = item.type === "Robot";
    return html`${this.head(kindName(item), item.name ?? item.label, this.buttons(item.type !== "Opening"))}
      ${item.fixed && this.origin(item, item.fixed)}
      ${isRobot ? suggestion(this.sheet(), this.shelf, item, this.run(), this.editor.items) : null}
      ${this.general(item)}
      ${
        schema
          ? objectRows(this.sheet(), schema, subject, [], isRobot ? this.modules(item) : null)
          : html`<p class="hint pad">${word("panel.editItInTheText")}</p>`
      }`;
  }

  /** Why an item cannot be changed here, and how it becomes one of the text's own. */
  private origin({ origin }: Item, why: string): View {
    const single = (by: keyof typeof SINGLE): View =>
      html`<button title=${SINGLE[by]} @click=${() => this.editor.makeSingle()}>${word("panel.makeSingle")}</button>`;
    return html`<div class="note">${sign(origin ?? "lock")}<span>${why}</span>${origin && single(origin)}</div>`;
  }

  /** Problems of the item that no row shows. */
  private general(item: Item): View {
    const own = this.problems().filter((problem) => problem.path && keyOf(problem.path) === keyOf(item.path));
    return own.map((problem) => note(problem.kind, said(problem.message)));
  }

  private world(): View {
    const { parsed } = this.editor.document;
    const schema = this.book.definition("");
    const loose = parsed.problems.filter(
      (problem) => !itemOf(problem.path, this.editor.items) && !this.isShown(problem),
    );
    const told = loose.map(({ kind, line, message }) =>
      note(kind, word("panel.line", { line, message: said(message) })),
    );
    const subject: Subject | null = parsed.world ? { path: [], ...given(parsed.world), fixed: false } : null;
    return html`${this.head(word("panel.world"), parsed.name || "", null)}${told}
      ${schema && subject && objectRows(this.sheet(), schema, subject, LISTS)}
      <p class="hint pad">${word("panel.selectAThingOnThe")}</p>`;
  }

  private isShown(problem: Problem): boolean {
    const [key] = problem.path ?? [];
    const known = this.book.definition("")?.["properties"] as Values | undefined;
    return key !== undefined && known !== undefined && key in known && !LISTS.includes(String(key));
  }

  /** Several have the fields that all of them share; a change is made to all. */
  private several(items: Item[]): View {
    const types = new Set(items.map((item) => item.type));
    const [first] = items;
    const group = wholeGroup(items, this.editor.items);
    const counted = group ?? word("panel.selected", { count: items.length });
    const kind = types.size === 1 && first ? kindName(first) : word("panel.severalThings");
    const title = group ? word("panel.groupOf", { count: items.length }) : kind;
    const schema = this.book.shared([...types]);
    return html`${this.head(title, counted, this.buttons(true))}${this.arranger(items)}${this.grouper(items, group)}
      ${schema && objectRows(this.sheet(items), schema, common(items), OF_ONE)}
      <p class="hint pad">${word("panel.dragThemTogetherTurnThem")}</p>`;
  }

  /** Buttons that align things and spread them evenly. */
  private arranger(items: Item[]): View {
    const count = arrangeable(items.filter((item) => !item.fixed)).length;
    if (count < 2) return null;
    const offered = (Object.keys(ARRANGEMENTS) as Arrangement[]).filter(
      (how) => count > 2 || !["across", "upright"].includes(how),
    );
    const buttons = offered.map((how) => iconButton(how, ARRANGEMENTS[how], () => void this.editor.arrange(how)));
    return html`<div class="arranger" role="group" aria-label=${word("panel.alignAndDistribute")}>${buttons}</div>`;
  }

  /** Buttons that make things one group and take them out of theirs. */
  private grouper(items: Item[], whole: string | null): View {
    const button = (text: string, together: boolean): View =>
      html`<button @click=${() => this.editor.group(together)}>${text}</button>`;
    const own = groupable(items);
    return html`<div class="grouper">${own.length > 1 && !whole ? button(word("edit.group"), true) : null}${
      own.some(groupOf) ? button(word("edit.ungroup"), false) : null
    }</div>`;
  }

  private sheet(items: Item[] = []): Sheet {
    const { book, tools, open, refused } = this;
    const change = (changes: Change[]): void => {
      refused.clear();
      const all = items.length ? items.flatMap((item) => changes.map((one) => retold(one, items[0], item))) : changes;
      void this.editor.apply([...all, ...all.flatMap((one) => this.editor.alongWith(one))]);
    };
    return { book, tools, problems: this.problems(), open, refused, redraw: () => this.soon(), change };
  }

  /** The modules of a robot, which stand in the run of the world. */
  private modules(robot: Item): View {
    const rows = driverRows(this.sheet(), robot, this.run());
    return html`<div class="modules"><h3>${word("panel.modules")}</h3>${rows}</div>`;
  }

  private run(): RunValues {
    const { run, world } = this.editor.document.parsed;
    return { values: run, raw: (world?.raw?.["run"] ?? {}) as Values };
  }

  private problems(): Problem[] {
    return this.editor.document.parsed.problems;
  }

  private head(kind: string, name: string, buttons: View): View {
    return html`<div class="panel-head"><div><span class="kind">${kind}</span><h2>${name}</h2></div>
      <div class="head-buttons">${buttons}</div></div>`;
  }

  private buttons(copies: boolean): View {
    return [
      copies ? iconButton("copy", word("panel.duplicateCtrlD"), () => this.editor.duplicate()) : null,
      iconButton("trash", word("panel.deleteDel"), () => void this.editor.remove()),
    ];
  }
}

function note(kind: string, text: string): View {
  return html`<p class="note ${kind}">${sign("warning")}${text}</p>`;
}

function given(world: { values: Values; written: string[]; raw?: Values }): {
  values: Values;
  written: string[];
  raw: unknown;
} {
  return { values: world.values, written: world.written, raw: world.raw };
}
