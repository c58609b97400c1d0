/** Several recordings beside each other: paths on one plan, errors in one chart, the figures of `mjsim compare`. */

import uPlot from "uplot";
import { Chart, type Line, NO_MARKS } from "../charts/chart";
import { noNees } from "../charts/sheet";
import { clock } from "../run/bar";
import type { Studio } from "../shell/view";
import { button, write } from "../ui/controls";
import { el } from "../ui/dom";
import { sign } from "../ui/icons";
import { faded } from "../ui/ink";
import { Signal } from "../ui/signal";
import { themeChanged } from "../ui/theme";
import { draw, html } from "../ui/view";
import { word } from "../words/words";
import { comparisonFigures } from "./compare_figures";
import { ComparePlan } from "./compare_plan";
import { type Comparison, compare, type Group, styleOf, type TimeLine } from "./comparison";
import { Player } from "./player";
import { Scrub } from "./scrub";

/** Steps by keys, and of the bar [s]. */
const STEP = 0.04;

export class Compare {
  readonly element = el("section", { class: "compare", tabindex: -1, "aria-label": word("review.comparison") });
  /** Emitted when the list of recordings is visible again. */
  readonly closed = new Signal();
  private readonly player = new Player();
  /** How many comparisons have been asked for, or left. */
  private turn = 0;
  private readonly scrub = new Scrub((time) => this.player.seek(time));
  private readonly plan = new ComparePlan();
  private readonly figures = el("div", {
    class: "compare-figures",
    tabindex: 0,
    role: "region",
    "aria-label": word("review.figures"),
  });
  private readonly sheet = el("div", {
    class: "run-sheet",
    "data-empty": word("charts.noneChosen"),
    tabindex: 0,
    role: "group",
    "aria-label": word("review.chartsCompared"),
  });
  private readonly title = el("strong", {}, "");
  private readonly time = el("output", { class: "run-value run-time" });
  private readonly play = button({ class: "primary run-main", title: word("review.playSpace") }, () =>
    this.player.toggle(),
  );
  private charts: Chart[] = [];
  private comparison: Comparison | null = null;

  constructor(
    private readonly studio: Studio,
    /** The view that it stands in the place of. */
    private readonly host: HTMLElement,
  ) {
    const back = word("review.backToTheRecordingsEscape");
    const view = html`<div class="run-bar" role="toolbar" aria-label=${word("review.comparison")}>
          <button type="button" title=${back} @click=${() => this.close()}>${sign("arrowLeft")}${word("review.back")}</button>
          ${this.play}${this.title}<span class="run-spring"></span>
          <label class="run-figure"><span>${word("review.time")}</span>${this.time}</label></div>
        <div class="compare-body">${this.plan.tile.element}${this.figures}</div>
        <div class="run-dock compare-dock">${this.scrub.element}${this.sheet}</div>`;
    draw(this.element, view);
    this.player.changed.on((time) => this.show(time));
    this.player.playingChanged.on((playing) => drawPlay(this.play, playing));
    drawPlay(this.play, false);
    themeChanged.on(() => this.comparison && draw(this.figures, comparisonFigures(this.comparison)));
  }

  get active(): boolean {
    return this.element.isConnected;
  }

  /** Compare recordings and sweeps, and show what came of it; the page stays as it is where they cannot be. */
  async open(paths: string[]): Promise<void> {
    const turn = ++this.turn;
    try {
      const comparison = await compare(paths);
      if (turn === this.turn) this.take(comparison, paths.length);
    } catch (error) {
      if (turn === this.turn) this.studio.toasts.error(error);
    }
  }

  close(): void {
    this.turn += 1;
    this.player.pause();
    if (!this.active) return;
    this.element.remove();
    this.host.toggleAttribute("data-comparing", false);
    this.closed.emit();
  }

  pause(): void {
    this.player.pause();
  }

  key(event: KeyboardEvent): boolean {
    const keys: Record<string, () => void> = {
      " ": () => this.player.toggle(),
      ".": () => this.player.step(1),
      ",": () => this.player.step(-1),
      ArrowRight: () => this.player.seek(this.player.time + 1),
      ArrowLeft: () => this.player.seek(this.player.time - 1),
      Home: () => this.player.seek(0),
      End: () => this.player.seek(this.player.end),
      Escape: () => this.close(),
    };
    const act = keys[event.key];
    if (!act) return this.plan.key(event);
    event.preventDefault();
    act();
    return true;
  }

  private take(comparison: Comparison, chosen: number): void {
    const { groups } = comparison;
    this.host.append(this.element);
    this.host.toggleAttribute("data-comparing", true);
    write(
      this.title,
      groups.length === 1
        ? word("review.chosenOfOneKind", { chosen })
        : word("review.chosenOfKinds", { chosen, kinds: groups.length }),
    );
    this.comparison = comparison;
    draw(this.figures, comparisonFigures(comparison));
    this.draw(comparison);
    this.plan.take(comparison);
    // The control that had the focus is hidden now.
    this.element.focus({ preventScroll: true });
    const ends = groups.flatMap(({ errors, nees }) => [...errors, nees].map(({ time }) => time[time.length - 1] ?? 0));
    const seconds = Math.max(0, ...ends);
    this.scrub.load(seconds, STEP, []);
    this.player.load(seconds, STEP);
  }

  private draw({ groups, nees }: Comparison): void {
    for (const chart of this.charts) chart.close();
    const handlers = { pick: (time: number) => this.player.seek(time) };
    const lines: Line[] = [];
    for (const [k, group] of groups.entries()) {
      lines.push(...errorLines(group, styleOf(k, groups.length), lines.length));
    }
    const errors = new Chart(
      { title: word("review.positionError"), unit: "m", lines, fromZero: true, atLeast: [0, 0.02], each: true },
      handlers,
      "compare",
    );
    errors.show(joined(groups.flatMap((group) => group.errors.flatMap(columnsOf))));
    const consistency = new Chart(
      {
        title: word("charts.neesBand"),
        unit: "",
        lines: groups.map(({ label }, k) => ({ label, ...styleOf(k, groups.length) })),
        band: nees.band,
        expected: nees.expected,
        logarithmic: true,
        fromZero: true,
        atLeast: [0, 12],
        digits: 2,
        each: true,
      },
      handlers,
      "compare",
    );
    consistency.explain(noNees(groups.some(({ estimated }) => estimated)));
    consistency.show(joined(groups.map((group) => [group.nees.time, group.nees.values])));
    this.charts = [errors, consistency];
    this.sheet.replaceChildren(...this.charts.map((chart) => chart.element));
  }

  private show(time: number): void {
    write(this.time, word("review.timeOf", { time: clock(time), whole: clock(this.player.end) }));
    this.scrub.show(time);
    this.plan.show(time);
    for (const chart of this.charts) chart.mark({ ...NO_MARKS, now: time });
  }
}

/** Draw the button that plays, or pauses. */
export function drawPlay(button: HTMLButtonElement, playing: boolean): void {
  draw(button, [sign(playing ? "pause" : "play"), word(playing ? "review.pause" : "review.play")]);
}

/** Lines of a group after so many others, in the order of its columns: the first one alone stands in the legend. */
function errorLines({ label, errors, runs }: Group, style: ReturnType<typeof styleOf>, before: number): Line[] {
  return errors.flatMap((line, number) => {
    const spread = line.low !== undefined;
    const told = spread ? word("review.medianOfNineOfTen", { label, runs }) : label;
    // In a table each line needs a name of its own.
    const name = errors.length > 1 ? { name: word("review.labelAndSeed", { label, seed: line.seed }) } : {};
    const own: Line = { label: number ? "" : told, ...name, ...style };
    if (!spread) return [own];
    const bound: Line = { label: "", name: `${label}: 95 %`, color: () => faded(style.color(), 0.35), width: 0.75 };
    return [
      own,
      bound,
      { ...bound, name: `${label}: 5 %`, fillTo: before + 2, fill: () => faded(style.color(), 0.14) },
    ];
  });
}

function columnsOf({ time, values, low, high }: TimeLine): Column[] {
  return low && high
    ? [
        [time, values],
        [time, high],
        [time, low],
      ]
    : [[time, values]];
}

type Column = [time: number[], values: (number | null)[]];

/** Columns on one clock: time, then one a column. */
function joined(columns: Column[]): Parameters<Chart["show"]>[0] {
  // Runs that ended early have no lines.
  if (!columns.length) return [[]];
  return uPlot.join(columns as unknown as uPlot.AlignedData[]) as unknown as Parameters<Chart["show"]>[0];
}
