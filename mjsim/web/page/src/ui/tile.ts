/** Framed views with headings: some of them are large and share their place as they were left, the others stand beside them. */

import { word } from "../words/words";
import { button, remembered } from "./controls";
import { kept, keysOf, type Layout, layoutIn, layoutText, placed, type Side, sideAt } from "./docking";
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

/** A split of the place of large views, with the bar between its parts. */
interface Halves {
  element: HTMLElement;
  bar: HTMLElement;
}

/** The large views, and a rail with the others. */
export class Stage {
  readonly element = el("div", { class: "run-stage" });
  readonly rail = el("div", { class: "run-tiles" });
  /** Told with the keys of the large views when these may be others. */
  readonly arranged = new Signal<readonly string[]>();
  private tiles: Tile[] = [];
  /** What is to be large; what is not there now may come. */
  private layout: Layout | null;
  /** Splits by their places among the others, as "stage-10": the second part of all, and of that the first. */
  private readonly halves = new Map<string, Halves>();
  private target: HTMLElement | null = null;

  /** @param key under which the browser keeps what is large */
  constructor(private readonly key: string) {
    this.layout = layoutIn(remembered(key));
    for (const kind of ["dragover", "dragleave", "drop"] as const)
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
    const [first] = keysOf(this.shown());
    this.choose(beside && first ? placed(this.shown(), key, first, "right") : key);
  }

  private choose(layout: Layout): void {
    this.layout = layout;
    remembered(this.key, layoutText(layout));
    this.arrange();
    this.rail.scrollTop = 0;
  }

  /** The views that are large, of those that there are. */
  private shown(): Layout {
    return kept(this.layout, (key) => this.tile(key) !== undefined) ?? this.tiles[0]?.key ?? "";
  }

  private tile(key: string): Tile | undefined {
    return this.tiles.find((tile) => tile.key === key);
  }

  private addButtons({ key, element }: Tile): void {
    if (element.querySelector(".run-enlarge")) return;
    const add = (title: string, name: "enlarge" | "beside"): HTMLElement =>
      button({ class: `quiet square run-${name}`, title }, () => this.enlarge(key, name === "beside"), icon(name));
    const parts = [add(word("ui.showBeside"), "beside"), add(word("run.showLarge"), "enlarge")];
    element.querySelector("header")?.append(el("span", { class: "run-ways" }, ...parts));
  }

  /** Views are dragged by their heads: to an edge of a large one to split it there, to its middle to take its place. */
  private drag(event: DragEvent, isRail: boolean): void {
    if (!event.dataTransfer?.types.includes(DRAGGED)) return;
    event.preventDefault();
    const over = isRail ? null : (event.target as Element).closest<HTMLElement>(".run-tile");
    const side = over ? sideOf(over, event) : "middle";
    this.point(event.type === "dragover" ? over : null, side);
    if (event.type !== "drop") return;
    const key = event.dataTransfer.getData(DRAGGED);
    if (!this.tile(key)) return;
    const at = over?.dataset["view"];
    const layout = isRail ? kept(this.shown(), (each) => each !== key) : at && placed(this.shown(), key, at, side);
    if (layout) this.choose(layout);
  }

  /** Show where a view would come. */
  private point(over: HTMLElement | null, side: Side): void {
    if (this.target !== over) delete this.target?.dataset["drop"];
    this.target = over;
    if (over) over.dataset["drop"] = side;
  }

  private arrange(): void {
    const shown = this.shown();
    const keys = keysOf(shown);
    const large = this.drawn(shown, this.key.replace(".", "-"));
    put(this.element, large ? [large] : []);
    this.element.toggleAttribute("data-split", keys.length > 1);
    put(
      this.rail,
      this.tiles.filter((tile) => !keys.includes(tile.key)).map((tile) => tile.element),
    );
    this.rail.hidden = keys.length >= this.tiles.length;
    this.arranged.emit(keys);
  }

  /** The element of a view, or of a split with both of its parts; what stays where it is is not touched. */
  private drawn(layout: Layout, place: string): HTMLElement | undefined {
    if (typeof layout === "string") return this.tile(layout)?.element;
    const { element, bar } = this.halvesAt(place);
    element.dataset["way"] = layout.way;
    const [first, second] = layout.parts.map((part, k) => this.drawn(part, `${place}${k}`));
    put(
      element,
      [first, bar, second].filter((each) => each !== undefined),
    );
    return element;
  }

  private halvesAt(place: string): Halves {
    const known = this.halves.get(place);
    if (known) return known;
    const element = el("div", { class: `run-split at-${place}` });
    const made = { element, bar: splitter(element, { label: word("ui.sizeOfTheView"), ...SIZES }) };
    this.halves.set(place, made);
    return made;
  }
}

/** Properties of the style of a split for the size of its first part. */
const SIZES = { width: "--first", height: "--first-high" };

function sideOf(tile: HTMLElement, { clientX, clientY }: DragEvent): Side {
  const { left, top, width, height } = tile.getBoundingClientRect();
  return sideAt((clientX - left) / width, (clientY - top) / height);
}
