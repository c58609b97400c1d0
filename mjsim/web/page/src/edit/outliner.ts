/** The tree of all things of the world by kind, with a search; only the rows that are seen are in the page. */

import type { Change, Item } from "../api";
import type { SchemaBook } from "../panel/schema";
import { keyOf } from "../plan/plan";
import { remembered } from "../ui/controls";
import { el, fill, isCommand } from "../ui/dom";
import { icon } from "../ui/icons";
import { unpressed } from "../ui/press";
import type { Editor } from "./editor";
import { groupOf } from "./groups";
import { HEADINGS, kindName } from "./kinds";
import "./outliner.css";
import { word } from "../words/words";

/** Height of a row [px], as in the style sheets, taller for fingers; rows beyond the window that are drawn too. */
const ROW = window.matchMedia("(pointer: coarse)").matches ? 40 : 26;
const SPARE = 6;

type Row = { list: string; count: number } | { item: Item; level: number; place: number; size: number };

export class Outliner {
  readonly element = el("section", { class: "outliner", "aria-label": word("edit.things") });
  private readonly search = el("input", {
    type: "search",
    placeholder: word("edit.searchByNameKindOr"),
    "aria-label": word("edit.searchThings"),
  });
  private readonly tree = el("div", {
    class: "outline-tree",
    role: "tree",
    tabindex: 0,
    "aria-label": word("edit.things"),
    "aria-multiselectable": "true",
  });
  private readonly paper = el("div", { role: "none" });
  private readonly none = el("p", { class: "hint pad", hidden: true });
  private readonly count = el("span", { class: "count" });
  private readonly head: HTMLButtonElement;
  private readonly shut = new Set<string>();
  private rows: Row[] = [];
  /** Where the keyboard stands: the key of a thing, or the name of a list. */
  private at = "";
  private renamed: string | null = null;
  private due = false;

  constructor(
    private readonly editor: Editor,
    private readonly book: SchemaBook,
    private readonly ask: (at: [number, number]) => void,
  ) {
    this.head = el(
      "button",
      { class: "quiet outline-head", onclick: () => this.open(!this.isOpen) },
      icon("down"),
      el("span", {}, word("edit.things")),
      this.count,
    );
    this.paper.className = "outline-paper";
    this.tree.append(this.paper);
    const body = el("div", { class: "outline-body" }, this.search, this.tree, this.none);
    this.element.append(this.head, body);
    this.open(remembered("edit.outliner") !== "no");
    const { document } = editor;
    document.parsedChanged.on(() => this.refresh());
    document.selectionChanged.on(() => this.showSelection());
    this.search.addEventListener("input", () => this.refresh());
    this.search.addEventListener("keydown", (event) => event.key === "ArrowDown" && this.tree.focus());
    this.tree.addEventListener("scroll", () => this.draw());
    this.tree.addEventListener("keydown", (event) => this.key(event));
    // Not on "click": rows drawn anew between press and release would get none.
    this.tree.addEventListener("mousedown", (event) => event.button === 0 && this.press(event));
    this.tree.addEventListener("dblclick", (event) => this.rowAt(event) && editor.asked.emit());
    this.tree.addEventListener("contextmenu", (event) => this.menu(event));
    new ResizeObserver(() => this.draw()).observe(this.tree);
    this.refresh();
  }

  /** Whether the thing has a name that stands in this text. */
  canRename(item: Item): boolean {
    const properties = this.book.definition(item.type)?.["properties"];
    return !item.fixed && typeof properties === "object" && properties !== null && "name" in properties;
  }

  /** Write the name of a thing anew, in its row. */
  rename(item: Item): void {
    if (!this.canRename(item)) return;
    this.open(true);
    this.search.value = "";
    this.shut.delete(String(item.path[0]));
    this.at = this.renamed = keyOf(item.path);
    this.refresh();
    this.reveal();
    this.draw();
  }

  private get isOpen(): boolean {
    return this.head.getAttribute("aria-expanded") === "true";
  }

  private open(on: boolean): void {
    this.head.setAttribute("aria-expanded", String(on));
    this.element.classList.toggle("shut", !on);
    remembered("edit.outliner", on ? "yes" : "no");
    this.draw();
  }

  /** Make the rows anew: other things, another search, a list opened or shut. */
  private refresh(): void {
    const { items } = this.editor;
    const wish = this.search.value.trim().toLowerCase();
    const found = wish ? items.filter((item) => wordsOf(item).includes(wish)) : items;
    this.count.textContent = wish
      ? word("shell.of", { number: found.length, count: items.length })
      : String(items.length);
    this.rows = rowsOf(found, wish ? new Set() : this.shut);
    this.none.hidden = found.length > 0;
    this.tree.hidden = found.length === 0;
    this.none.textContent = wish ? word("edit.nothingIsCalled", { wish }) : word("edit.nothingStandsHereYet");
    this.paper.style.height = `${this.rows.length * ROW}px`;
    this.draw();
  }

  private showSelection(): void {
    const [first] = this.editor.selected;
    if (first && !this.editor.selected.some((item) => keyOf(item.path) === this.at)) this.at = keyOf(first.path);
    this.reveal();
    this.draw();
  }

  /** Scroll to where the keyboard stands. */
  private reveal(): void {
    const top = this.rows.findIndex((row) => idOf(row) === this.at) * ROW;
    const { scrollTop, clientHeight } = this.tree;
    if (top < 0) return;
    if (top < scrollTop) this.tree.scrollTop = top;
    else if (top + ROW > scrollTop + clientHeight) this.tree.scrollTop = top + ROW - clientHeight;
  }

  /** Draw with the next picture, however often it was asked for. */
  private draw(): void {
    if (this.due) return;
    this.due = true;
    requestAnimationFrame(() => {
      this.due = false;
      // While a name is written its row stays.
      if (!this.paper.querySelector("input")) unpressed(this.paper, () => this.paint());
    });
  }

  private paint(): void {
    const first = Math.max(0, Math.floor(this.tree.scrollTop / ROW) - SPARE);
    const last = Math.ceil((this.tree.scrollTop + this.tree.clientHeight) / ROW) + SPARE;
    const chosen = new Set(this.editor.document.selection.map(keyOf));
    const shown = this.rows.slice(first, last).map((row, index) => this.drawn(row, first + index, chosen));
    fill(this.paper, ...shown);
    const active = shown.find((row) => row.dataset["key"] === this.at);
    if (active) this.tree.setAttribute("aria-activedescendant", active.id);
    else this.tree.removeAttribute("aria-activedescendant");
    const field = this.paper.querySelector("input");
    field?.focus();
    field?.select();
  }

  private drawn(row: Row, index: number, chosen: Set<string>): HTMLElement {
    const id = idOf(row);
    const common = {
      id: `outline-${index}`,
      role: "treeitem",
      "data-key": id,
      class: `outline-row${id === this.at ? " active" : ""}`,
      style: `top: ${index * ROW}px`,
    };
    if ("list" in row) {
      const shut = !this.search.value.trim() && this.shut.has(row.list);
      const parts = [
        icon("down"),
        el("b", {}, HEADINGS[row.list] ?? row.list),
        el("span", { class: "count" }, String(row.count)),
      ];
      return el(
        "div",
        { ...common, "aria-level": 1, "aria-expanded": String(!shut), "aria-selected": "false" },
        ...parts,
      );
    }
    const { item, level, place, size } = row;
    const known = {
      "aria-level": level,
      "aria-posinset": place,
      "aria-setsize": size,
      "aria-selected": String(chosen.has(id)),
    };
    const name = this.renamed === id ? this.nameField(item) : el("span", { class: "outline-name" }, item.label);
    const held = item.fixed
      ? el(
          "span",
          { class: "held", title: item.fixed },
          icon(item.origin ?? "lock"),
          el("span", { class: "sr" }, item.fixed),
        )
      : null;
    const group = groupOf(item)
      ? el("span", { class: "outline-group", title: word("edit.ofGroup", { group: groupOf(item) }) }, groupOf(item))
      : null;
    return el("div", { ...common, ...known }, name, el("span", { class: "outline-model" }, modelOf(item)), group, held);
  }

  private nameField(item: Item): HTMLInputElement {
    const field = el("input", { "aria-label": word("edit.newName"), value: item.name ?? "", spellcheck: "false" });
    const end = (keep: boolean): void => {
      if (this.renamed === null) return;
      this.renamed = null;
      const value = field.value.trim();
      field.remove();
      if (keep && value && value !== item.name) void this.give(item, value);
      this.draw();
    };
    field.addEventListener("blur", () => end(true));
    field.addEventListener("keydown", (event) => {
      event.stopPropagation();
      if (event.key !== "Enter" && event.key !== "Escape") return;
      event.preventDefault();
      end(event.key === "Enter");
      this.tree.focus();
    });
    return field;
  }

  private give(item: Item, value: string): Promise<boolean> {
    const change: Change = { op: "set", path: [...item.path, "name"], value };
    return this.editor.apply([change, ...this.editor.alongWith(change)]);
  }

  private rowAt(event: Event): Row | null {
    const key =
      event.target instanceof Element ? event.target.closest<HTMLElement>(".outline-row")?.dataset["key"] : undefined;
    return this.rows.find((row) => idOf(row) === key) ?? null;
  }

  private press(event: MouseEvent): void {
    const row = this.rowAt(event);
    if (!row || event.target instanceof HTMLInputElement) return;
    if ("list" in row) {
      this.at = row.list;
      return this.fold(row.list, !this.shut.has(row.list));
    }
    if (event.shiftKey) this.selectTo(row);
    else if (isCommand(event) || this.editor.adding) this.switchOne(row.item);
    else this.editor.select([row.item]);
    this.at = idOf(row);
    this.bring(row.item);
    this.draw();
  }

  private menu(event: MouseEvent): void {
    event.preventDefault();
    const row = this.rowAt(event);
    if (!row || !("item" in row)) return;
    if (!this.editor.selected.includes(row.item)) this.editor.select([row.item]);
    this.ask([event.clientX, event.clientY]);
  }

  private switchOne(item: Item): void {
    const others = this.editor.selected.filter((other) => other !== item);
    this.editor.select(others.length < this.editor.selected.length ? others : [...others, item]);
  }

  /** Select all from where the keyboard stands. */
  private selectTo(row: Row): void {
    const [from, to] = [this.rows.findIndex((other) => idOf(other) === this.at), this.rows.indexOf(row)];
    const between = this.rows.slice(Math.max(0, Math.min(from, to)), Math.max(from, to) + 1);
    this.editor.select(between.flatMap((other) => ("item" in other ? [other.item] : [])));
  }

  private fold(list: string, shut: boolean): void {
    if (shut) this.shut.add(list);
    else this.shut.delete(list);
    this.refresh();
  }

  /** Bring a thing onto the paper that is seen. */
  private bring(item: Item): void {
    const at = item.at ?? item.polygons[0]?.[0];
    const [x0, y0, x1, y1] = this.editor.plan.view.bounds;
    if (at && (at[0] < x0 || at[0] > x1 || at[1] < y0 || at[1] > y1)) this.editor.plan.follow(at);
  }

  private key(event: KeyboardEvent): void {
    if (isCommand(event) || event.altKey || event.target !== this.tree) return;
    const now = this.rows.findIndex((row) => idOf(row) === this.at);
    const page = Math.max(1, Math.floor(this.tree.clientHeight / ROW) - 1);
    const places: Record<string, number> = {
      ArrowDown: now + 1,
      ArrowUp: now - 1,
      PageDown: now + page,
      PageUp: now - page,
      Home: 0,
      End: this.rows.length - 1,
    };
    const place = places[event.key];
    const row = this.rows[now];
    if (place !== undefined) this.go(Math.max(0, Math.min(place, this.rows.length - 1)));
    else if (!row || !this.act(event.key, row)) return;
    event.preventDefault();
    event.stopPropagation();
  }

  private go(place: number): void {
    const row = this.rows[place];
    if (!row) return;
    this.at = idOf(row);
    this.editor.select("item" in row ? [row.item] : []);
    if ("item" in row) this.bring(row.item);
    this.reveal();
    this.draw();
  }

  /** A key on a row; false when it is none of the tree. */
  private act(key: string, row: Row): boolean {
    if (key === "ArrowLeft" || key === "ArrowRight") {
      const list = "list" in row ? row.list : String(row.item.path[0]);
      if ("item" in row && key === "ArrowLeft") this.go(this.rows.findIndex((other) => idOf(other) === list));
      else if ("list" in row) this.fold(list, key === "ArrowLeft");
      return true;
    }
    if ("list" in row) return (key === "Enter" || key === " ") && (this.fold(row.list, !this.shut.has(row.list)), true);
    if (key === "Enter") this.editor.asked.emit();
    else return false;
    return true;
  }
}

/** The rows of things: lists in the order of the text of a world, what is part of a thing below it. */
function rowsOf(items: Item[], shut: Set<string>): Row[] {
  const lists = new Map<string, Item[]>(Object.keys(HEADINGS).map((list) => [list, []]));
  for (const item of items) lists.get(String(item.path[0]))?.push(item);
  return [...lists].flatMap(([list, own]): Row[] => {
    if (own.length === 0) return [];
    const things = own.map((item, index) => ({
      item,
      level: item.path.length > 3 ? 3 : 2,
      place: index + 1,
      size: own.length,
    }));
    return [{ list, count: own.length }, ...(shut.has(list) ? [] : things)];
  });
}

function idOf(row: Row): string {
  return "list" in row ? row.list : keyOf(row.item.path);
}

/** What a thing is made from: its preset, its shape or its picture. */
function modelOf(item: Item): string {
  const { preset, image, model } = item.values;
  const given = [preset, model, image].find((value) => typeof value === "string");
  return given ? String(given).replace(/^.*\//, "") : item.name === null ? "" : kindName(item).toLowerCase();
}

function wordsOf(item: Item): string {
  return [item.label, groupOf(item) ?? "", item.kind, item.type, String(item.path[0]), modelOf(item)]
    .join(" ")
    .toLowerCase();
}
