/** Framed views with headings: one or two of them are large, as they were left, the others stand beside them. */

import { word } from "../words/words";
import { button, remembered } from "./controls";
import { type Child, el, put } from "./dom";
import { icon } from "./icons";
import { Signal } from "./signal";
import { splitter } from "./splitter";

export interface Tile {
  key: string;
  element: HTMLElement;
}

/** Frame a view. */
export function makeTile(key: string, title: string, body: HTMLElement, ...actions: Child[]): Tile {
  const head = el("h2", { draggable: "true" }, title);
  head.addEventListener("dragstart", (event) => event.dataTransfer?.setData(DRAGGED, key));
  const parts = [el("header", {}, head, ...actions), body];
  return { key, element: el("section", { class: "run-tile", "data-view": key, "aria-label": title }, ...parts) };
}

/** What of a tile is dragged: its key. */
const DRAGGED = "application/x-mjsim-view";

/** The large views, and a rail with the others. */
export class Stage {
  readonly element = el("div", { class: "run-stage" });
  readonly rail = el("div", { class: "run-tiles" });
  /** Told with the keys of the large views when these may be others. */
  readonly arranged = new Signal<readonly string[]>();
  private tiles: Tile[] = [];
  /** Keys of what is to be large, the first on the left; what is not there now may come. */
  private large: string[];
  private readonly bar = splitter(this.element, {
    label: word("ui.sizeOfTheView"),
    width: "--first",
  });

  /** @param key under which the browser keeps what is large */
  constructor(private readonly key: string) {
    this.large = remembered(key)?.split(" ").filter(Boolean) ?? [];
    for (const kind of ["dragover", "drop"] as const)
      for (const place of [this.element, this.rail])
        place.addEventListener(kind, (event) => this.drag(event, place === this.rail));
  }

  /** Show these; the first one is large unless others of them were chosen. */
  show(tiles: Tile[]): void {
    for (const tile of tiles) if (!this.tiles.includes(tile)) this.addButtons(tile);
    this.tiles = tiles;
    this.arrange();
  }

  /** Make one of them large, alone or beside the first of those that are. */
  enlarge(key: string, beside = false): void {
    const [first] = this.shown().map((tile) => tile.key);
    this.choose(beside && first && first !== key ? [first, key] : [key]);
  }

  private choose(large: string[]): void {
    this.large = large;
    remembered(this.key, large.join(" "));
    this.arrange();
    this.rail.scrollTop = 0;
  }

  /** The views that are large, of those that there are. */
  private shown(): Tile[] {
    const chosen = this.large.flatMap((key) => this.tiles.find((tile) => tile.key === key) ?? []);
    return chosen.length ? chosen : this.tiles.slice(0, 1);
  }

  private addButtons({ key, element }: Tile): void {
    if (element.querySelector(".run-enlarge")) return;
    const add = (title: string, name: "enlarge" | "beside"): HTMLElement =>
      button({ class: `quiet square run-${name}`, title }, () => this.enlarge(key, name === "beside"), icon(name));
    const parts = [add(word("ui.showBeside"), "beside"), add(word("run.showLarge"), "enlarge")];
    element.querySelector("header")?.append(el("span", { class: "run-ways" }, ...parts));
  }

  /** Views are dragged by their heads: over a large one to its place, to its left or right half to stand beside it. */
  private drag(event: DragEvent, isRail: boolean): void {
    if (!event.dataTransfer?.types.includes(DRAGGED)) return;
    event.preventDefault();
    if (event.type !== "drop") return;
    const key = event.dataTransfer.getData(DRAGGED);
    const others = this.shown().flatMap((tile) => (tile.key === key ? [] : [tile.key]));
    if (isRail) return others.length ? this.choose(others) : undefined;
    const { left, width } = this.element.getBoundingClientRect();
    const place = (event.clientX - left) / width;
    const [first = key] = others;
    this.choose(place < 1 / 3 ? [key, first] : place > 2 / 3 ? [first, key] : [key]);
  }

  private arrange(): void {
    const [first, second] = this.shown();
    const others = this.tiles.filter((tile) => tile !== first && tile !== second);
    const large = [first?.element, second && this.bar, second?.element];
    put(
      this.element,
      large.filter((each) => each !== undefined),
    );
    this.element.toggleAttribute("data-split", second !== undefined);
    put(
      this.rail,
      others.map((tile) => tile.element),
    );
    this.rail.hidden = others.length === 0;
    this.arranged.emit(this.shown().map((tile) => tile.key));
  }
}
