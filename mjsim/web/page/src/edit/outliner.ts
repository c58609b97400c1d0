/** The tree of all things of the world by kind, with a search; only the rows that are seen are in the page. */

import type { Change, Item } from "../api";
import type { SchemaBook } from "../panel/schema";
import { keyOf } from "../plan/plan";
import { remembered } from "../ui/controls";
import { el, isCommand } from "../ui/dom";
import { sign } from "../ui/icons";
import { draw, html, live, nothing, repeat, type View, withValue } from "../ui/view";
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
  private readonly tree = el("div", {
    class: "outline-tree",
    role: "tree",
    tabindex: 0,
    "aria-label": word("edit.things"),
    "aria-multiselectable": "true",
  });
  private readonly paper = el("div", { role: "none" });
  private isOpen = remembered("edit.outliner") !== "no";
  /** What is searched for. */
  private wish = "";
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
    this.paper.className = "outline-paper";
    this.tree.append(this.paper);
    const { document } = editor;
    document.parsedChanged.on(() => this.refresh());
    document.selectionChanged.on(() => this.showSelection());
    this.tree.addEventListener("scroll", () => this.draw());
    this.tree.addEventListener("keydown", (event) => this.key(event));
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
    this.wish = "";
    this.shut.delete(String(item.path[0]));
    this.at = this.renamed = keyOf(item.path);
    this.refresh();
    this.reveal();
    this.draw();
  }

  private open(on: boolean): void {
    this.isOpen = on;
    remembered("edit.outliner", on ? "yes" : "no");
    this.refresh();
  }

  /** Make the rows anew: other things, another search, a list opened or shut. */
  private refresh(): void {
    const { items } = this.editor;
    const wish = this.wish.trim().toLowerCase();
    const found = wish ? items.filter((item) => wordsOf(item).includes(wish)) : items;
    this.rows = rowsOf(found, wish ? new Set() : this.shut);
    this.tree.hidden = found.length === 0;
    this.paper.style.height = `${this.rows.length * ROW}px`;
    this.element.classList.toggle("shut", !this.isOpen);
    const search = withValue((value) => {
      this.wish = value;
      this.refresh();
    });
    const count = wish ? word("shell.of", { number: found.length, count: items.length }) : items.length;
    const none = wish ? word("edit.nothingIsCalled", { wish }) : word("edit.nothingStandsHereYet");
    const view = html`<button class="quiet outline-head" aria-expanded=${this.isOpen}
        @click=${() => this.open(!this.isOpen)}>${sign("down")}<span>${word("edit.things")}</span><span class="count"
        >${count}</span></button>
      <div class="outline-body"><input type="search" placeholder=${word("edit.searchByNameKindOr")} @input=${search}
        aria-label=${word("edit.searchThings")} .value=${live(this.wish)}
        @keydown=${(event: KeyboardEvent) => event.key === "ArrowDown" && this.tree.focus()}>${this.tree}
        <p class="hint pad" ?hidden=${found.length > 0}>${none}</p></div>`;
    draw(this.element, view);
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
      this.paint();
    });
  }

  private paint(): void {
    const first = Math.max(0, Math.floor(this.tree.scrollTop / ROW) - SPARE);
    const last = Math.ceil((this.tree.scrollTop + this.tree.clientHeight) / ROW) + SPARE;
    const chosen = new Set(this.editor.document.selection.map(keyOf));
    const shown = this.rows.slice(first, last);
    const rows = repeat(shown, idOf, (row, k) => this.row(row, first + k, chosen));
    draw(this.paper, rows);
    const active = shown.findIndex((row) => idOf(row) === this.at);
    if (active >= 0) this.tree.setAttribute("aria-activedescendant", `outline-${first + active}`);
    else this.tree.removeAttribute("aria-activedescendant");
    const field = this.paper.querySelector("input");
    if (field === document.activeElement) return;
    field?.focus();
    field?.select();
  }

  private row(row: Row, index: number, chosen: Set<string>): View {
    const id = idOf(row);
    const isList = "list" in row;
    const shut = isList && !this.wish.trim() && this.shut.has(id);
    const [level, place, size] = "list" in row ? [1, nothing, nothing] : [row.level, row.place, row.size];
    return html`<div id="outline-${index}" role="treeitem" data-key=${id} class="outline-row ${id === this.at ? "active" : ""}" style="top: ${index * ROW}px"
      aria-level=${level} aria-posinset=${place} aria-setsize=${size} aria-selected=${!isList && chosen.has(id)}
      aria-expanded=${isList ? !shut : nothing}>${"list" in row ? listParts(row) : this.thing(row.item, id)}</div>`;
  }

  private thing(item: Item, id: string): View {
    const group = groupOf(item);
    const name = this.renamed === id ? this.nameField(item) : html`<span class="outline-name">${item.label}</span>`;
    const held = (why: string): View =>
      html`<span class="held" title=${why}>${sign(item.origin ?? "lock")}<span class="sr">${why}</span></span>`;
    return html`${name}<span class="outline-model">${modelOf(item)}</span>${
      group && html`<span class="outline-group" title=${word("edit.ofGroup", { group })}>${group}</span>`
    }${item.fixed && held(item.fixed)}`;
  }

  private nameField(item: Item): View {
    const end = (keep: boolean, field: HTMLInputElement): void => {
      if (this.renamed === null) return;
      this.renamed = null;
      const value = field.value.trim();
      if (keep && value && value !== item.name) void this.give(item, value);
      this.draw();
    };
    const key = (event: KeyboardEvent): void => {
      event.stopPropagation();
      if (event.key !== "Enter" && event.key !== "Escape") return;
      event.preventDefault();
      end(event.key === "Enter", event.target as HTMLInputElement);
      this.tree.focus();
    };
    return html`<input aria-label=${word("edit.newName")} value=${item.name ?? ""} spellcheck="false"
      @blur=${(event: Event) => end(true, event.target as HTMLInputElement)} @keydown=${key}>`;
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

function listParts({ list, count }: { list: string; count: number }): View {
  return html`${sign("down")}<b>${HEADINGS[list] ?? list}</b><span class="count">${count}</span>`;
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
