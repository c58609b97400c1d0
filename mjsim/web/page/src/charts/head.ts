/** What stands above a chart: its title with the unit, and the names of its lines. */

import { themeChanged } from "../ui/theme";
import type { ChartSettings, Line } from "./chart";

export function heading({ title, unit }: ChartSettings): HTMLElement {
  const element = document.createElement("strong");
  element.textContent = unit ? `${title} [${unit}]` : title;
  return element;
}

/** The names of lines in their colours; `endings` takes what lets go of it. */
export function legend(lines: Pick<Line, "label" | "color">[], endings: (() => void)[]): HTMLElement {
  const list = document.createElement("span");
  list.className = "run-chart-legend";
  for (const line of lines.filter((each) => each.label)) {
    const entry = document.createElement("span");
    const swatch = document.createElement("i");
    const paint = (): void => void (swatch.style.background = line.color());
    paint();
    endings.push(themeChanged.on(paint));
    entry.append(swatch, line.label);
    list.append(entry);
  }
  return list;
}
