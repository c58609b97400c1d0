/** The charts of a robot's run: errors within their bounds, NEES, time a module. */

import type { History } from "../run/history";
import type { RobotFacts } from "../run/protocol";
import { faded, readTokens, rowColor } from "../ui/ink";
import { Signal } from "../ui/signal";
import { word } from "../words/words";
import { Chart, type ChartSettings, type Handlers, type Line, type Marks, NO_MARKS } from "./chart";

type Column = (number | null)[];

/** 2.5 % and 97.5 % quantiles of chi-square with three degrees of freedom. */
const NEES_BAND: [number, number] = [0.216, 9.348];
const NEES_EXPECTED = 3;
/** Bounds beyond so many times the largest error are cut off, as the error would be flat beside them. */
const BOUNDS_SHOWN = 10;

export type Kind = "distance" | "x" | "y" | "heading" | "nees" | "timing";

export const KINDS: { kind: Kind; label: string }[] = [
  { kind: "distance", label: word("charts.position") },
  { kind: "x", label: "x" },
  { kind: "y", label: "y" },
  { kind: "heading", label: word("charts.heading") },
  { kind: "nees", label: "NEES" },
  { kind: "timing", label: word("charts.timePerModule") },
];

/** What there is to show of a robot: one that stands has no errors of its pose; null where there is no robot. */
export function kindsOf(robot: RobotFacts | null): Kind[] {
  if (!robot) return [];
  return KINDS.map(({ kind }) => kind).filter((kind) => robot.can_drive || kind === "timing");
}

const AXES = { x: 0, y: 1, heading: 2 } as const;

function bounded(title: string, unit: string, atLeast: number): ChartSettings {
  const bound = (label: string, share: number, fillTo?: number): Line => ({
    label,
    ...(label ? {} : { name: share > 0.5 ? "−2σ" : "−3σ" }),
    color: () => faded(readTokens().estimate, share),
    width: 0.75,
    ...(fillTo === undefined ? {} : { fillTo, fill: () => faded(readTokens().estimate, 0.11) }),
  });
  const lines = [
    { label: word("charts.error"), color: () => readTokens().estimate, width: 1.5 },
    bound("2σ", 0.75),
    bound("", 0.75, 2),
    bound("3σ", 0.45),
    bound("", 0.45, 4),
  ];
  return { title, unit, lines, atLeast: [-atLeast, atLeast], expected: 0, mostOfFirst: BOUNDS_SHOWN };
}

function settingsOf(kind: Kind, modules: string[]): ChartSettings {
  const estimate = (): string => readTokens().estimate;
  switch (kind) {
    case "distance":
      return {
        title: word("charts.positionError"),
        unit: "m",
        lines: [
          { label: word("charts.estimate"), color: estimate, width: 1.5 },
          { label: word("charts.odometry"), color: () => readTokens().odometry },
        ],
        fromZero: true,
        atLeast: [0, 0.02],
      };
    case "x":
      return bounded(word("charts.xError"), "m", 0.02);
    case "y":
      return bounded(word("charts.yError"), "m", 0.02);
    case "heading":
      return { ...bounded(word("charts.headingError"), "deg", 0.5), digits: 2 };
    case "nees":
      return {
        title: word("charts.neesBand"),
        unit: "",
        lines: [{ label: "", color: estimate, width: 1.25 }],
        band: NEES_BAND,
        expected: NEES_EXPECTED,
        logarithmic: true,
        fromZero: true,
        atLeast: [0, 12],
        digits: 2,
      };
    case "timing":
      return {
        title: word("charts.time"),
        unit: "ms",
        lines: modules.map((label, k) => ({ label, color: () => rowColor(k) })),
        fromZero: true,
        atLeast: [0, 1],
        digits: 1,
        robust: true,
      };
  }
}

function columnsOf(kind: Kind, history: History, modules: string[]): Column[] {
  switch (kind) {
    case "distance":
      return [...history.distance];
    case "nees":
      return [history.nees];
    case "timing":
      return modules.map((name) => history.timing.get(name) ?? []);
    default: {
      const k = AXES[kind];
      const times = (factor: number): Column => history.sigmas[k].map((each) => (each === null ? null : factor * each));
      return [history.errors[k], times(2), times(-2), times(3), times(-3)];
    }
  }
}

/** Why a run has no NEES. */
export function noNees(estimated: boolean | null): string {
  if (estimated === null) return word("charts.noValues");
  return word(estimated ? "charts.noNeesSingular" : "charts.noNeesDeadReckoning");
}

/** A row of charts that show the same run. */
export class Sheet {
  readonly element = document.createElement("div");
  /** Told which kinds have something to show. */
  readonly offered = new Signal<readonly Kind[]>();
  private offers: readonly Kind[] = [];
  private readonly charts = new Map<Kind, Chart>();
  private modules: string[] = [];
  private drawn: [History | null, number] = [null, -1];
  private marks = NO_MARKS;

  constructor(
    private kinds: Kind[],
    private readonly handlers: Handlers = {},
    private readonly sync?: string,
  ) {
    this.element.className = "run-sheet";
    // It scrolls where there are many; so it can be reached by keys.
    this.element.tabIndex = 0;
    this.element.setAttribute("role", "group");
    this.element.setAttribute("aria-label", word("charts.charts"));
    this.arrange();
  }

  choose(kinds: Kind[]): void {
    this.kinds = kinds;
    this.drawn = [null, -1];
    this.arrange();
  }

  /** Only charts of these kinds have something to show. */
  offer(kinds: readonly Kind[]): void {
    if (kinds.join() === this.offers.join()) return;
    this.offers = kinds;
    this.drawn = [null, -1];
    this.arrange();
    this.offered.emit(kinds);
  }

  /** Draw a history, unless it is as it was. */
  show(history: History): void {
    if (this.drawn[0] === history && this.drawn[1] === history.version) return;
    this.drawn = [history, history.version];
    // Sorted, so that a module has the same colour in each browser, whichever it heard of first.
    const modules = [...history.timing.keys()].sort();
    if (modules.join() !== this.modules.join()) {
      this.modules = modules;
      this.drop("timing");
      this.arrange();
    }
    for (const [kind, chart] of this.charts) {
      if (kind === "nees") chart.explain(noNees(history.estimated));
      chart.show([history.time, ...columnsOf(kind, history, this.modules)]);
    }
  }

  mark(marks: Marks): void {
    this.marks = marks;
    for (const chart of this.charts.values()) chart.mark(marks);
  }

  private drop(kind: Kind): void {
    this.charts.get(kind)?.close();
    this.charts.delete(kind);
  }

  private arrange(): void {
    const kinds = this.kinds.filter((kind) => this.offers.includes(kind));
    for (const kind of [...this.charts.keys()]) if (!kinds.includes(kind)) this.drop(kind);
    this.element.toggleAttribute("data-nothing", this.offers.length === 0);
    this.element.dataset["empty"] = word(this.offers.length ? "charts.noneChosen" : "charts.nothingToDraw");
    for (const kind of kinds) {
      let chart = this.charts.get(kind);
      if (!chart) {
        chart = new Chart(settingsOf(kind, this.modules), this.handlers, this.sync);
        this.charts.set(kind, chart);
        if (this.marks !== NO_MARKS) chart.mark(this.marks);
      }
      this.element.append(chart.element);
    }
  }
}
