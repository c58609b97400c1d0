/** The menu of a chart that gives it away: as PNG, SVG or CSV. */

import { button } from "../ui/controls";
import { el } from "../ui/dom";
import { icon } from "../ui/icons";
import { word } from "../words/words";
import { type Figure, fileName, savePng, saveSvg } from "./figure";
import { csvOf, save } from "./save";

export interface Savable {
  /** As it is now, in the colours of the light theme. */
  figure(): Figure;
  /** Heads, then rows. */
  table(): (string | number | null | undefined)[][];
}

export function savingMenu(chart: Savable): HTMLElement {
  const menu = el("details", { class: "run-chart-save" });
  const item = (label: string, keep: () => void): HTMLElement =>
    button(
      { class: "run-small" },
      () => {
        keep();
        menu.open = false;
      },
      label,
    );
  menu.append(
    el("summary", { title: word("charts.saveAsAFile"), "aria-label": word("charts.saveAsAFile") }, icon("download")),
    el(
      "div",
      {},
      item("PNG", () => void savePng(chart.figure())),
      item("SVG", () => saveSvg(chart.figure())),
      item("CSV", () =>
        save(new Blob([csvOf(chart.table())], { type: "text/csv" }), `${fileName(chart.figure().title)}.csv`),
      ),
    ),
  );
  menu.addEventListener("keydown", (event) => {
    if (event.key !== "Escape" || !menu.open) return;
    menu.open = false;
    event.stopPropagation();
  });
  return menu;
}
