/** The figures of a comparison as tables: what is certain, what to know, the means, all differences. */

import { save } from "../charts/save";
import { button } from "../ui/controls";
import { el } from "../ui/dom";
import { icon } from "../ui/icons";
import { rowColor } from "../ui/ink";
import { themeChanged } from "../ui/theme";
import { said, word, wordOr } from "../words/words";
import type { Comparison, Difference, Group } from "./comparison";

export function comparisonFigures(comparison: Comparison): HTMLElement[] {
  const { groups, know, cells, differences } = comparison;
  const titled = (name: string): string => titleOf(name, comparison);
  const certain = comparison.certain.map(([better = "", than = "", figure = "", ...rest]) => [
    better,
    than,
    titled(figure),
    ...rest,
  ]);
  const means = comparison.means.map(([figure = "", ...rest]) => [titled(figure), ...rest]);
  const nothing = el("p", {}, word("review.noFigureIsCertainTo"));
  const heads = [
    word("review.better"),
    word("review.than"),
    word("review.in"),
    word("review.byInterval"),
    word("review.pairs"),
  ];
  return [
    legend(groups),
    el("h3", {}, word("review.whatIsCertain")),
    certain.length ? table(heads, certain, { class: "compare-certain" }) : nothing,
    ...(know.length
      ? [
          el("h3", {}, word("review.whatToKnow")),
          el("ul", { class: "compare-know" }, ...know.map((told) => el("li", {}, `${said(told)}.`))),
        ]
      : []),
    el(
      "div",
      { class: "run-figures-head" },
      el("h3", {}, word("review.figuresOf", { cells: said(cells) })),
      csvButton(comparison),
    ),
    table([word("review.figure"), ...groups.map(({ label }) => label)], means, { class: "compare-means" }),
    ...(differences.length
      ? [el("h3", {}, word("review.differencesOfPairsMeanInterval")), ...differenceTables(differences)]
      : []),
  ];
}

/** The name of a figure in the language of the page, with its unit where that stands behind it. */
function titleOf(name: string, { keys }: Comparison): string {
  const cut = name.lastIndexOf(" [");
  const [title, unit] = cut < 0 ? [name, ""] : [name.slice(0, cut), name.slice(cut)];
  return wordOr("figure", keys[title] ?? "", title) + unit;
}

function legend(groups: Group[]): HTMLElement {
  const entries = groups.map(({ label, runs }, k) => {
    const swatch = el("i", {});
    const paint = (): void => void (swatch.style.background = rowColor(k));
    paint();
    // Each comparison makes others: those that are gone need no colours.
    const stop = themeChanged.on(() => (swatch.isConnected ? paint() : stop()));
    return el(
      "li",
      {},
      swatch,
      el("b", {}, label),
      el("span", { class: "hint" }, word(runs === 1 ? "review.oneRun" : "review.runs", { runs })),
    );
  });
  return el("ul", { class: "compare-legend", "aria-label": word("review.groups") }, ...entries);
}

function csvButton({ csv }: Comparison): HTMLElement {
  const keep = (): void => save(new Blob([csv], { type: "text/csv" }), "comparison.csv");
  return button({ class: "run-small" }, keep, icon("copy"), word("review.saveCsv"));
}

/** A table for every two groups. */
function differenceTables(differences: Difference[]): HTMLElement[] {
  const pairs = [...new Set(differences.map(({ first, second }) => word("review.less", { second, first })))];
  return pairs.map((pair) => {
    const own = differences.filter(({ first, second }) => word("review.less", { second, first }) === pair);
    return table([pair, "", word("review.pairs")], own.map(differenceRow), { class: "compare-differences" });
  });
}

function differenceRow({ figure, title, unit, mean, low, high, pairs, reason }: Difference): string[] {
  const short = (value: number): string => String(Number(value.toPrecision(3)));
  const interval = low === null || high === null ? "" : ` [${short(low)}, ${short(high)}]`;
  const text = mean === null ? said(reason) : `${short(mean)}${interval} ${unit}`.trim();
  return [wordOr("figure", figure, title), text, String(pairs)];
}

function table(heads: string[], rows: string[][], attributes: { class: string }): HTMLElement {
  const row = ([first, ...cells]: string[]): HTMLElement =>
    el("tr", {}, el("th", { scope: "row" }, first ?? ""), ...cells.map((cell) => el("td", {}, cell)));
  const head = el("tr", {}, ...heads.map((text) => (text ? el("th", { scope: "col" }, text) : el("td", {}))));
  return el(
    "div",
    { class: "compare-table" },
    el("table", attributes, el("thead", {}, head), el("tbody", {}, ...rows.map(row))),
  );
}
