/** The frame of Run and Review: panels, the large views and pictures beside each other, charts below, with bars between. */

import { word } from "../words/words";
import { button } from "./controls";
import { el } from "./dom";
import { icon } from "./icons";
import { splitter } from "./splitter";
import type { Tabs } from "./tabs";
import type { Lodger, Stage } from "./tile";

export interface Parts {
  side: HTMLElement;
  /** The panels in it, which may stand among the large views, as may the charts. */
  tabs: Tabs;
  stage: Stage;
  /** What the stage is in, or that. */
  large: HTMLElement;
  rail: HTMLElement;
  /** Below them, with the charts at its end: what is above them, and they as high as the bar is dragged. */
  dock: HTMLElement;
  charts: { head: HTMLElement; sheet: HTMLElement };
}

/** Append them to a view. */
export function columns(view: HTMLElement, { side, tabs, stage, large, rail, dock, charts }: Parts): HTMLElement {
  const body = el("div", { class: "run-body" }, side, large, rail);
  side.after(splitter(view, { label: word("ui.sizeOfThePanel"), panel: side, width: "--side" }));
  rail.before(splitter(view, { label: word("ui.sizeOfThePictures"), panel: rail, width: "--rail" }));
  dock.prepend(splitter(view, { label: word("ui.sizeOfTheCharts"), panel: charts.sheet, height: "--charts-kept" }));
  const below = chartsOf(dock, charts);
  below.handle.addEventListener("click", () => stage.addLarge(below.key));
  charts.head.append(below.handle);
  stage.lodge(dock, [below]);
  stage.lodge(side, tabs.lodgers());
  tabs.offered.on(() => stage.refresh());
  tabs.addAction(besideButton(() => stage.addLarge(`panel:${tabs.now}`)));
  view.append(body, dock);
  return body;
}

function besideButton(press: () => void): HTMLButtonElement {
  return button({ class: "quiet square run-beside", title: word("ui.showBeside") }, press, icon("beside"));
}

/** The charts as a panel that may stand elsewhere. */
function chartsOf(dock: HTMLElement, { head, sheet }: Parts["charts"]): Lodger {
  const body = el("div", { class: "run-charts" }, head, sheet);
  dock.append(body);
  const lodge = (isAway: boolean): void => {
    dock.toggleAttribute("data-away", isAway);
    if (!isAway) dock.append(body);
  };
  const handle = besideButton(() => undefined);
  return { key: "panel:charts", title: word("ui.charts"), body, handle, isThere: () => true, lodge };
}
