/** The figures between two times, as a table and as CSV. */

import { csvOf, save } from "../charts/save";
import { el } from "../ui/dom";
import { sign } from "../ui/icons";
import { draw, html, nothing, type View } from "../ui/view";
import { word, wordOr } from "../words/words";
import type { Figures } from "./recording";

interface Row {
  robot: string;
  /** What they are called in files, and their keys. */
  group: string;
  groupKey: string;
  /** Which of the group: mean, RMSE and so on; empty where there is one only. */
  part: string;
  partKey: string;
  value: number;
  unit: string;
}

/** Units at the end of a key, and how they are written. */
const UNITS: [suffix: string, unit: string][] = [
  ["_m", "m"],
  ["_deg", "deg"],
  ["_ms", "ms"],
  ["_s", "s"],
  ["_seconds", "s"],
];
/** What most people ask for comes first. */
const FIRST = [
  "position_error",
  "heading_error",
  "odometry_error",
  "nees",
  "nis",
  "ate",
  "rpe",
  "landmark_error",
  "distance",
  "bumps",
  "falls",
  "coverage",
];
/** Lists, and what says how a figure was made, do not belong into a short table. */
const LEFT_OUT = new Set([
  "band",
  "mean_band",
  "each",
  "aligned_each",
  "transient",
  "recovery",
  "fault",
  "milliseconds",
]);

/** Counts and shares have no unit though their group has one. */
const PLAIN = new Set(["count", "false", "singular", "in_band", "independent"]);

/** All numbers of all robots, each with its unit. */
export function rowsOf(figures: Figures): Row[] {
  return Object.entries(figures.robots).flatMap(([robot, values]) => {
    const rows = Object.entries(values).flatMap(([key, value]) => leaves(robot, key, value));
    return rows.sort((a, b) => rank(a.groupKey) - rank(b.groupKey));
  });
}

function leaves(robot: string, key: string, value: unknown): Row[] {
  const { label: group, key: groupKey, unit } = named(key);
  if (typeof value === "number") return [{ robot, group, groupKey, part: "", partKey: "", value, unit }];
  if (typeof value !== "object" || value === null || Array.isArray(value) || LEFT_OUT.has(key)) return [];
  return Object.entries(value as Record<string, unknown>)
    .filter(([part]) => !LEFT_OUT.has(part))
    .flatMap(([part, each]) =>
      typeof each === "number"
        ? [{ robot, group, groupKey, part: words(part), partKey: part, value: each, unit: PLAIN.has(part) ? "" : unit }]
        : [],
    );
}

function named(key: string): { label: string; key: string; unit: string } {
  const found = UNITS.find(([suffix]) => key.endsWith(suffix));
  const own = found ? key.slice(0, -found[0].length) : key;
  const label = words(own);
  return {
    key: own,
    label: /^(nees|nis|ate|rpe)/.test(label) ? label.toUpperCase() : label.charAt(0).toUpperCase() + label.slice(1),
    unit: found?.[1] ?? "",
  };
}

function words(key: string): string {
  return key.replaceAll("_", " ").replace("rmse", "RMSE").replace(/^rms$/, "RMS");
}

function rank(key: string): number {
  const found = FIRST.findIndex((first) => key.startsWith(first));
  return found < 0 ? FIRST.length : found;
}

function shown(value: number): string {
  if (Number.isInteger(value)) return String(value);
  return Math.abs(value) >= 100 ? value.toFixed(1) : value.toPrecision(4);
}

export class Table {
  readonly element = el("div", { class: "run-figures" });
  private rows: Row[] = [];

  constructor(private readonly tell: (text: string) => void) {
    this.ask();
  }

  /** Say how a part is marked. */
  ask(): void {
    this.rows = [];
    draw(this.element, html`<p class="hint">${word("review.markAPartToGet")}</p>`);
  }

  wait(): void {
    draw(this.element, html`<p class="hint" role="status">${word("review.workingOutTheFigures")}</p>`);
  }

  fail(message: string): void {
    draw(this.element, html`<p class="run-problem" role="alert">${message}</p>`);
  }

  /** Show those of a part, or of all where it has no ends. */
  show(figures: Figures, from: number | null, to: number | null): void {
    this.rows = rowsOf(figures);
    const isPart = from !== null && to !== null;
    const title = isPart
      ? word("review.fromTo", { from: from.toFixed(2), to: to.toFixed(2) })
      : word("review.wholeRecording");
    const copy = word("review.copyAsCsv");
    const view = html`<div class="run-figures-head"><strong>${title}</strong><button type="button" class="run-small" title=${copy}
        @click=${() => this.copy()}>${sign("copy")}${copy}</button></div>${this.table()}`;
    draw(this.element, view);
  }

  /** The table as text: robot, figure, value in full, unit. */
  csv(): string {
    const rows = this.rows.map(({ robot, group, part, value, unit }) => [robot, group, part, value, unit]);
    return csvOf([["robot", "figure", "part", "value", "unit"], ...rows]);
  }

  private table(): View {
    const several = new Set(this.rows.map((row) => row.robot)).size > 1;
    let last = "";
    const body = this.rows.map((row) => {
      const own = wordOr("statistic", row.groupKey, row.group);
      const group = several ? `${row.robot}: ${own}` : own;
      const begins = group !== last && row.part !== "";
      last = group;
      const head = begins ? html`<tr><th colspan="3" scope="rowgroup">${group}</th></tr>` : nothing;
      return [head, rowOf(row, row.part ? wordOr("statistic", row.partKey, row.part) : group)];
    });
    return html`<table><thead><tr><th scope="col">${word("review.figure")}</th><th scope="col">${word("review.value")}</th>
      <th scope="col">${word("review.unit")}</th></tr></thead><tbody>${body}</tbody></table>`;
  }

  private async copy(): Promise<void> {
    const text = this.csv();
    try {
      await navigator.clipboard.writeText(text);
      this.tell(word("review.copiedAsCsv"));
    } catch {
      // A page that is not served from this machine may not write to the clipboard: offer a file.
      save(new Blob([text], { type: "text/csv" }), "statistics.csv");
      this.tell(word("review.theBrowserDoesNotAllow"));
    }
  }
}

function rowOf({ robot, group, part, value, unit }: Row, label: string): View {
  const head = part ? html`<th scope="row">${label}</th>` : html`<th class="run-alone">${label}</th>`;
  return html`<tr data-figure=${part ? `${group}, ${part}` : group} data-robot=${robot}>${head}
    <td data-value=${value}>${shown(value)}</td><td class="run-unit">${unit}</td></tr>`;
}
