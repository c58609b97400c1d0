/** Framed views with headings: some of them are large and share their place as they were left, the others stand beside them. */

import { word } from "../words/words";
import { button, remembered } from "./controls";
import {
  kept,
  keysOf,
  type Layout,
  layoutIn,
  layoutText,
  placed,
  placedBeside,
  type Side,
  shareOf,
  sideAt,
} from "./docking";
import { type Child, el, isTyping, put } from "./dom";
import { draggedBy } from "./dragging";
import { type IconName, icon } from "./icons";
import { Signal } from "./signal";
import { splitter } from "./splitter";

export interface Tile {
  key: string;
  element: HTMLElement;
}

/** Frame a view. */
export function makeTile(key: string, title: string, body: HTMLElement, ...actions: Child[]): Tile {
  const parts = [el("header", {}, el("h2", {}, title), ...actions), body];
  return { key, element: el("section", { class: "run-tile", "data-view": key, "aria-label": title }, ...parts) };
}

/** A panel that has a place of its own, and may stand among the large views instead. */
export interface Lodger {
  key: string;
  title: string;
  body: HTMLElement;
  /** It is dragged by that from its own place. */
  handle: HTMLElement;
  isThere: () => boolean;
  /** It goes to the large views, or comes back. */
  lodge: (isAway: boolean) => void;
}

/** Where the pointer would drop a view: at a side of a large one, or back to its own place. */
type Spot = { over: HTMLElement; side: Side } | "home" | null;

const ARROWS: Record<string, Exclude<Side, "middle">> = {
  ArrowLeft: "left",
  ArrowRight: "right",
  ArrowUp: "top",
  ArrowDown: "bottom",
};

/** A split of the place of large views, with the bar between its parts. */
interface Halves {
  element: HTMLElement;
  bar: HTMLElement;
}

/** The large views, and a rail with the others; panels come from places of their own. */
export class Stage {
  readonly element = el("div", { class: "run-stage" });
  readonly rail = el("div", { class: "run-tiles" });
  /** Told with the keys of the large views when these may be others. */
  readonly arranged = new Signal<readonly string[]>();
  private tiles: Tile[] = [];
  private readonly lodgers = new Map<string, Lodger & { tile: Tile }>();
  private readonly homes: HTMLElement[] = [this.rail];
  /** What is to be large; what is not there now may come. */
  private layout: Layout | null;
  /** Splits by their places among the others, as "stage-10": the second part of all, and of that the first. */
  private readonly halves = new Map<string, Halves>();
  private target: HTMLElement | null = null;

  /** @param key under which the browser keeps what is large */
  constructor(private readonly key: string) {
    this.layout = layoutIn(remembered(key));
  }

  /** Let panels stand among the large views, too; dropped on their home they go back there. */
  lodge(home: HTMLElement, lodgers: Lodger[]): void {
    this.homes.push(home);
    for (const lodger of lodgers) {
      const tile = makeTile(lodger.key, lodger.title, el("div", { class: "run-panel" }));
      this.lodgers.set(lodger.key, { ...lodger, tile });
      this.addWays(tile);
      this.lead(lodger.handle, lodger.key);
      lodger.handle.addEventListener("keydown", (event) => this.move(event, lodger.key));
    }
  }

  /** What there is may be other than before. */
  refresh(): void {
    if (this.tiles.length) this.arrange();
  }

  /** Show these; the first one is large unless others of them were chosen. */
  show(tiles: Tile[]): void {
    for (const tile of tiles) if (!this.tiles.includes(tile)) this.addWays(tile);
    this.tiles = tiles;
    this.arrange();
  }

  /** Make one of them large, alone. */
  enlarge(key: string): void {
    this.choose(key);
  }

  /** Make it large beside the largest of those that are, along its longer side. */
  addLarge(key: string): void {
    const boxes = keysOf(this.shown()).map((at) => ({ at, box: this.tile(at)?.element.getBoundingClientRect() }));
    const area = (box?: DOMRect): number => (box ? box.width * box.height : 0);
    const { at, box } = boxes.reduce((one, other) => (area(other.box) > area(one.box) ? other : one));
    this.choose(placed(this.shown(), key, at, box && box.height > box.width ? "bottom" : "right"));
    this.focus(key, "back");
  }

  private choose(layout: Layout | null): void {
    this.layout = layout;
    remembered(this.key, layout === null ? "" : layoutText(layout));
    this.arrange();
    this.rail.scrollTop = 0;
  }

  /** The views that are large, of those that there are. */
  private shown(): Layout {
    return kept(this.layout, (key) => this.tile(key) !== undefined) ?? this.tiles[0]?.key ?? "";
  }

  private tile(key: string): Tile | undefined {
    const lodger = this.lodgers.get(key);
    return lodger?.isThere() ? lodger.tile : this.tiles.find((tile) => tile.key === key);
  }

  private addWays({ key, element }: Tile): void {
    const header = element.querySelector("header");
    if (!header || header.querySelector(".run-ways")) return;
    const add = (kind: string, title: string, press: () => void, name: IconName): HTMLElement =>
      button({ class: `quiet square run-${kind}`, title }, press, icon(name));
    const ways = [
      add("beside", word("ui.showBeside"), () => this.addLarge(key), "beside"),
      add("enlarge", word("run.showLarge"), () => this.enlarge(key), "enlarge"),
      add("back", word("ui.putBack"), () => this.putBack(key), "close"),
    ];
    header.append(el("span", { class: "run-ways" }, ...ways));
    this.lead(header.querySelector("h2") ?? header, key);
    header.addEventListener("keydown", (event) => this.move(event, key));
  }

  /** Views are dragged by their heads: to an edge of a large one to split it there, to its middle to take its place. */
  private lead(head: HTMLElement, key: string): void {
    draggedBy(head, {
      over: (at) => this.point(at && this.spotAt(at)),
      drop: (at) => {
        const spot = this.spotAt(at);
        if (spot === "home") this.putBack(key);
        else if (spot) this.choose(placed(this.shown(), key, spot.over.dataset["view"] ?? "", spot.side));
      },
    });
  }

  /** Ctrl and an arrow put a view to that side of all others. */
  private move(event: KeyboardEvent, key: string): void {
    const side = ARROWS[event.key];
    if (!side || !event.ctrlKey || isTyping(event.target)) return;
    event.preventDefault();
    event.stopPropagation();
    this.choose(placedBeside(this.shown(), key, side));
    this.focus(key, "back");
  }

  private putBack(key: string): void {
    this.choose(kept(this.shown(), (each) => each !== key));
    const lodger = this.lodgers.get(key);
    if (lodger) lodger.handle.focus();
    else this.focus(key, "enlarge");
  }

  private focus(key: string, way: string): void {
    this.tile(key)?.element.querySelector<HTMLElement>(`.run-${way}`)?.focus();
  }

  private spotAt({ clientX, clientY }: PointerEvent): Spot {
    const at = document.elementFromPoint(clientX, clientY);
    if (this.homes.some((home) => home.contains(at))) return "home";
    const over = at?.closest<HTMLElement>(".run-tile");
    if (!over || !this.element.contains(over)) return null;
    const { left, top, width, height } = over.getBoundingClientRect();
    return { over, side: sideAt((clientX - left) / width, (clientY - top) / height) };
  }

  /** Show where a view would come. */
  private point(spot: Spot): void {
    const over = spot && spot !== "home" ? spot.over : null;
    if (this.target !== over) delete this.target?.dataset["drop"];
    this.target = over;
    if (over && spot && spot !== "home") over.dataset["drop"] = spot.side;
    for (const home of this.homes) home.toggleAttribute("data-home", spot === "home");
  }

  private arrange(): void {
    const shown = this.shown();
    const keys = keysOf(shown);
    this.lend(keys);
    const large = this.drawn(shown, this.key.replace(".", "-"));
    put(this.element, large ? [large] : []);
    this.element.toggleAttribute("data-split", keys.length > 1);
    const others = this.tiles.filter((tile) => !keys.includes(tile.key));
    put(
      this.rail,
      others.map((tile) => tile.element),
    );
    this.rail.hidden = others.length === 0;
    this.arranged.emit(keys);
  }

  /** Bring the panels that are among the large views there, and the others home. */
  private lend(keys: string[]): void {
    for (const { key, body, tile, lodge } of this.lodgers.values()) {
      const [place, isAway] = [tile.element.querySelector(".run-panel"), keys.includes(key)];
      if (isAway === (body.parentElement === place)) continue;
      lodge(isAway);
      if (isAway) place?.append(body);
    }
  }

  /** The element of a view, or of a split with both of its parts; what stays where it is is not touched. */
  private drawn(layout: Layout, place: string): HTMLElement | undefined {
    if (typeof layout === "string") return this.tile(layout)?.element;
    const { element, bar } = this.halvesAt(place);
    element.dataset["way"] = layout.way;
    element.style.setProperty("--share", `${shareOf(layout)}%`);
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
