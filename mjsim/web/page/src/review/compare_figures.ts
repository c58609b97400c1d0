/** The figures of a comparison as tables: what is certain, what to know, the means, all differences. */

import { save } from "../charts/save";
import { sign } from "../ui/icons";
import { rowColor } from "../ui/ink";
import { html, nothing, type View } from "../ui/view";
import { said, word, wordOr } from "../words/words";
import type { Comparison, Difference, Group } from "./comparison";

export function comparisonFigures(comparison: Comparison): View {
  const { groups, know, cells, differences } = comparison;
  const titled = (rows: string[][], column: number): string[][] =>
    rows.map((row) => row.map((cell, k) => (k === column ? titleOf(cell, comparison) : cell)));
  const certain = titled(comparison.certain, 2);
  const means = titled(comparison.means, 0);
  const heads = (["review.better", "review.than", "review.in", "review.byInterval", "review.pairs"] as const).map(
    (key) => word(key),
  );
  const known = html`<h3>${word("review.whatToKnow")}</h3>
    <ul class="compare-know">${know.map((told) => html`<li>${said(told)}.</li>`)}</ul>`;
  const pairs = html`<h3>${word("review.differencesOfPairsMeanInterval")}</h3>${differenceTables(differences)}`;
  return html`${legend(groups)}<h3>${word("review.whatIsCertain")}</h3>
    ${certain.length ? table(heads, certain, "compare-certain") : html`<p>${word("review.noFigureIsCertainTo")}</p>`}
    ${know.length ? known : nothing}
    <div class="run-figures-head"><h3>${word("review.figuresOf", { cells: said(cells) })}</h3>${csvButton(comparison)}</div>
    ${table([word("review.figure"), ...groups.map(({ label }) => label)], means, "compare-means")}
    ${differences.length ? pairs : nothing}`;
}

/** The name of a figure in the language of the page, with its unit where that stands behind it. */
function titleOf(name: string, { keys }: Comparison): string {
  const cut = name.lastIndexOf(" [");
  const [title, unit] = cut < 0 ? [name, ""] : [name.slice(0, cut), name.slice(cut)];
  return wordOr("figure", keys[title] ?? "", title) + unit;
}

function legend(groups: Group[]): View {
  const entries = groups.map(
    ({ label, runs }, k) => html`<li><i style="background: ${rowColor(k)}"></i><b>${label}</b><span class="hint"
      >${word(runs === 1 ? "review.oneRun" : "review.runs", { runs })}</span></li>`,
  );
  return html`<ul class="compare-legend" aria-label=${word("review.groups")}>${entries}</ul>`;
}

function csvButton({ csv }: Comparison): View {
  const keep = (): void => save(new Blob([csv], { type: "text/csv" }), "comparison.csv");
  return html`<button type="button" class="run-small" @click=${keep}>${sign("copy")}${word("review.saveCsv")}</button>`;
}

/** A table for every two groups. */
function differenceTables(differences: Difference[]): View {
  const pairs = [...new Set(differences.map(({ first, second }) => word("review.less", { second, first })))];
  return pairs.map((pair) => {
    const own = differences.filter(({ first, second }) => word("review.less", { second, first }) === pair);
    return table([pair, "", word("review.pairs")], own.map(differenceRow), "compare-differences");
  });
}

function differenceRow({ figure, title, unit, mean, low, high, pairs, reason }: Difference): string[] {
  const short = (value: number): string => String(Number(value.toPrecision(3)));
  const interval = low === null || high === null ? "" : ` [${short(low)}, ${short(high)}]`;
  const text = mean === null ? said(reason) : `${short(mean)}${interval} ${unit}`.trim();
  return [wordOr("figure", figure, title), text, String(pairs)];
}

function table(heads: string[], rows: string[][], kind: string): View {
  const row = ([first, ...cells]: string[]): View =>
    html`<tr><th scope="row">${first}</th>${cells.map((cell) => html`<td>${cell}</td>`)}</tr>`;
  const head = heads.map((text) => (text ? html`<th scope="col">${text}</th>` : html`<td></td>`));
  return html`<div class="compare-table"><table class=${kind}><thead><tr>${head}</tr></thead>
    <tbody>${rows.map(row)}</tbody></table></div>`;
}
