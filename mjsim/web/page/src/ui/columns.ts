/** The frame of Run and Review: panels, the large view and pictures beside each other, charts below, with bars between. */

import { word } from "../words/words";
import { el } from "./dom";
import { splitter } from "./splitter";

export interface Parts {
  side: HTMLElement;
  large: HTMLElement;
  rail: HTMLElement;
  /** Below them; what it ends with is as high as its bar is dragged. */
  dock: HTMLElement;
}

/** Append them to a view. */
export function columns(view: HTMLElement, { side, large, rail, dock }: Parts): HTMLElement {
  const body = el("div", { class: "run-body" }, side, large, rail);
  side.after(splitter(view, { label: word("ui.sizeOfThePanel"), panel: side, width: "--side" }));
  rail.before(splitter(view, { label: word("ui.sizeOfThePictures"), panel: rail, width: "--rail" }));
  const charts = dock.lastElementChild as HTMLElement;
  dock.prepend(splitter(view, { label: word("ui.sizeOfTheCharts"), panel: charts, height: "--charts-kept" }));
  view.append(body, dock);
  return body;
}
