/** A framed view with a heading; one of them is large, the others stand beside it. */

import { word } from "../words/words";
import { button } from "./controls";
import { type Child, el, put } from "./dom";
import { icon } from "./icons";
import { Signal } from "./signal";

export interface Tile {
  key: string;
  element: HTMLElement;
}

/** Frame a view. */
export function makeTile(key: string, title: string, body: HTMLElement, ...actions: Child[]): Tile {
  const head = el("header", {}, el("h2", {}, title), ...actions);
  return { key, element: el("section", { class: "run-tile", "data-view": key, "aria-label": title }, head, body) };
}

/** The large view, and a rail with the others. */
export class Stage {
  readonly element = el("div", { class: "run-stage" });
  readonly rail = el("div", { class: "run-tiles" });
  /** Told with the key of the large view when that may be another. */
  readonly arranged = new Signal<string>();
  private tiles: Tile[] = [];
  private large = "";

  /** Show these; the first one is large unless another of them was chosen. */
  show(tiles: Tile[]): void {
    for (const tile of tiles) if (!this.tiles.includes(tile)) this.addButton(tile);
    this.tiles = tiles;
    if (!tiles.some((tile) => tile.key === this.large)) this.large = tiles[0]?.key ?? "";
    this.arrange();
  }

  /** Make one of them large. */
  enlarge(key: string): void {
    this.large = key;
    this.arrange();
    this.rail.scrollTop = 0;
  }

  private addButton(tile: Tile): void {
    if (tile.element.querySelector(".run-enlarge")) return;
    const enlarge = button(
      { class: "quiet square run-enlarge", title: word("run.showLarge") },
      () => this.enlarge(tile.key),
      icon("enlarge"),
    );
    tile.element.querySelector("header")?.append(enlarge);
  }

  private arrange(): void {
    const large = this.tiles.find((tile) => tile.key === this.large);
    const others = this.tiles.filter((tile) => tile !== large);
    put(this.element, large ? [large.element] : []);
    put(
      this.rail,
      others.map((tile) => tile.element),
    );
    this.rail.hidden = others.length === 0;
    this.arranged.emit(this.large);
  }
}
