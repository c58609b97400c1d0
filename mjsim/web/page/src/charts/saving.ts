/** The menu of a chart that gives it away: as PNG, SVG or CSV. */

import { el } from "../ui/dom";
import { sign } from "../ui/icons";
import { draw, html, type View } from "../ui/view";
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
  const item = (label: string, keep: () => unknown): View => {
    const press = (): void => {
      keep();
      menu.open = false;
    };
    return html`<button type="button" class="run-small" @click=${press}>${label}</button>`;
  };
  const csv = (): void =>
    save(new Blob([csvOf(chart.table())], { type: "text/csv" }), `${fileName(chart.figure().title)}.csv`);
  const title = word("charts.saveAsAFile");
  const view = html`<summary title=${title} aria-label=${title}>${sign("download")}</summary><div>
      ${item("PNG", () => savePng(chart.figure()))}${item("SVG", () => saveSvg(chart.figure()))}${item("CSV", csv)}</div>`;
  draw(menu, view);
  menu.addEventListener("keydown", (event) => {
    if (event.key !== "Escape" || !menu.open) return;
    menu.open = false;
    event.stopPropagation();
  });
  return menu;
}
