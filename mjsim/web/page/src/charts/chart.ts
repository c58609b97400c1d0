/** uPlot, dressed as the page: colours from the style sheet, bands, marks, a size that follows its box. */

import uPlot from "uplot";
import { enlarger } from "../ui/enlarge";
import { faded, inLight, readTokens } from "../ui/ink";
import { themeChanged } from "../ui/theme";
import { word } from "../words/words";
import { decade, LOGARITHMIC } from "./decades";
import { type Curve, type Figure, type Ink, rangeOf } from "./figure";
import { heading, legend } from "./head";
import { quantile, rowAt } from "./rows";
import { across, upright } from "./rules";
import { savingMenu } from "./saving";

type Column = (number | null | undefined)[];

export interface Line {
  label: string;
  /** What it is called in files; its label, or the title, unless given. */
  name?: string;
  /** Read whenever it is drawn, as light may turn to dark. */
  color(): string;
  width?: number;
  dash?: number[];
  /** The area between this line and the one of that index (counted from 1) is filled. */
  fillTo?: number;
  fill?(): string;
}

export interface ChartSettings {
  title: string;
  unit: string;
  lines: Line[];
  /** A band behind all lines: from, to. */
  band?: [number, number];
  /** A line right across. */
  expected?: number;
  /** Linear up to 1, logarithmic beyond. */
  logarithmic?: boolean;
  /** The axis begins at 0. */
  fromZero?: boolean;
  /** The axis shows at least from and to these. */
  atLeast?: [number, number];
  /** The few largest values may be cut off: one slow tick does not press all others flat. */
  robust?: boolean;
  /** The axis shows at most so many times what the first line reaches: other lines may lie beyond. */
  mostOfFirst?: number;
  /** Figures shown after the point. */
  digits?: number;
  /** The values of all lines of the legend are read at a time, not only that of the first line. */
  each?: boolean;
  /** The axis shows what values lie between, and need not reach zero. */
  tight?: boolean;
}

/** What stands across a chart at times: the scrub bar, a marked part, events. */
export interface Marks {
  now: number | null;
  from: number | null;
  to: number | null;
  events: number[];
}

export const NO_MARKS: Marks = { now: null, from: null, to: null, events: [] };

export interface Handlers {
  /** The pointer chose a time [s]. */
  pick?(time: number): void;
  /** A part was marked by dragging [s]. */
  select?(from: number, to: number): void;
}

/** Width of a digit at an axis [px]. */
const LETTER = 6.4;
/** Share of the values that a robust axis shows. */
const MOST_SHOWN = 0.99;

/** One chart over time in a box of its own. */
export class Chart {
  readonly element = document.createElement("figure");
  private readonly plot: uPlot;
  private readonly reading = document.createElement("output");
  private marks = NO_MARKS;
  private readonly endings: (() => void)[] = [];
  private readonly box = document.createElement("div");
  private most = Number.POSITIVE_INFINITY;

  constructor(
    private readonly settings: ChartSettings,
    private readonly handlers: Handlers = {},
    sync?: string,
  ) {
    this.element.className = "run-chart unknown";
    const head = document.createElement("figcaption");
    head.append(
      heading(settings),
      legend(settings.lines, this.endings),
      savingMenu(this),
      enlarger(this.element),
      this.reading,
    );
    this.box.className = "run-chart-box";
    this.explain(word("charts.noValues"));
    this.element.append(head, this.box);
    const empty = [[], ...settings.lines.map(() => [])] as unknown as uPlot.AlignedData;
    this.plot = new uPlot(this.options(sync), empty, this.box);
    const sizes = new ResizeObserver(() => this.fit(this.box));
    sizes.observe(this.box);
    this.endings.push(
      () => sizes.disconnect(),
      themeChanged.on(() => this.plot.redraw(false, true)),
    );
  }

  /** Say in the empty chart why there are no values. */
  explain(why: string): void {
    this.box.dataset["empty"] = why;
  }

  /** Show columns: time, then one a line. */
  show(columns: [Column, ...Column[]]): void {
    const { robust, mostOfFirst, atLeast = [0, 0] } = this.settings;
    if (robust) this.most = 1.3 * quantile(columns.slice(1).flat(), MOST_SHOWN);
    if (mostOfFirst) this.most = mostOfFirst * Math.max(atLeast[1], largest(columns[1] ?? []));
    this.element.classList.toggle(
      "unknown",
      columns.slice(1).every((column) => column.every((each) => each == null)),
    );
    this.plot.setData(columns as unknown as uPlot.AlignedData);
  }

  mark(marks: Marks): void {
    this.marks = marks;
    this.plot.redraw(false, false);
    this.read(marks.now);
  }

  /** What is shown, as vectors on white. */
  figure(): Figure {
    return inLight(() => {
      const { title, unit, band, expected, logarithmic = false } = this.settings;
      const { x, y } = this.plot.scales;
      return {
        title,
        x: word("charts.timeAxis"),
        y: unit ? `${title.toLowerCase()} [${unit}]` : title,
        curves: this.curves(),
        xRange: [x?.min ?? 0, x?.max ?? 1],
        yRange: [y?.min ?? 0, y?.max ?? 1],
        logarithmic,
        ...(band ? { band } : {}),
        ...(expected === undefined ? {} : { across: expected }),
        behind: readTokens().seen,
        ink: inkNow(),
      };
    });
  }

  table(): (string | number | null | undefined)[][] {
    const { lines, title } = this.settings;
    const [times, ...columns] = this.plot.data as unknown as Column[];
    const rows = (times ?? []).map((time, row) => [time, ...columns.map((column) => column[row])]);
    return [[word("charts.timeAxis"), ...lines.map((line) => line.name ?? (line.label || title))], ...rows];
  }

  private curves(): Curve[] {
    const [x = [], ...columns] = this.plot.data as unknown as Column[];
    return this.settings.lines.map((line, k) => ({
      label: line.label,
      color: line.color(),
      width: line.width ?? 1.25,
      ...(line.dash ? { dash: line.dash } : {}),
      x,
      y: columns[k] ?? [],
      ...(line.fillTo === undefined ? {} : { to: columns[line.fillTo - 1] ?? [], fill: line.fill?.() ?? "none" }),
    }));
  }

  close(): void {
    for (const end of this.endings) end();
    this.plot.destroy();
    this.element.remove();
  }

  private fit(box: HTMLElement): void {
    const [width, height] = [box.clientWidth, box.clientHeight];
    if (width && height) this.plot.setSize({ width, height });
  }

  private options(sync?: string): uPlot.Options {
    const { settings } = this;
    const lines = settings.logarithmic ? LOGARITHMIC : {};
    const axis = (values: uPlot.Axis): uPlot.Axis => ({
      stroke: () => readTokens().muted,
      grid: { stroke: () => readTokens().hair, width: 1 },
      ticks: { show: false },
      font: "11px system-ui, sans-serif",
      gap: 4,
      ...values,
    });
    return {
      width: 240,
      height: 120,
      legend: { show: false },
      padding: [6, 8, 0, 0],
      scales: {
        // Of a single time, the axis would go to 100 s.
        x: { time: false, range: (_plot, low, high) => [low, high === low ? low + 1 : high] },
        y: {
          ...(settings.logarithmic ? { distr: 4, asinh: 1 } : {}),
          range: (_plot, low, high) => this.range(low, high),
        },
      },
      axes: [
        axis({ size: 22, space: 48 }),
        // A quarter of the height: then two numbers stand at it at least, whatever lies between them.
        axis({
          // As wide as the longest number, such as a UTM coordinate, but no narrower than small ones need.
          size: (_plot, values) => 12 + LETTER * Math.max(5, ...(values ?? []).map((each) => String(each).length)),
          space: (_plot, _axis, _low, _high, room) => Math.min(22, room / 4),
          ...lines,
          values: (_plot, ticks) => ticks.map((tick) => this.label(tick)),
        }),
      ],
      series: [{}, ...settings.lines.map(series)],
      bands: settings.lines.flatMap(bands),
      cursor: {
        y: false,
        points: { show: false },
        drag: { x: Boolean(this.handlers.select), y: false, setScale: false },
        ...(sync ? { sync: { key: sync, setSeries: false } } : {}),
      },
      hooks: {
        drawClear: [(plot) => this.behind(plot)],
        draw: [(plot) => this.before(plot)],
        setCursor: [
          (plot) => this.read(plot.cursor.idx == null ? this.marks.now : (plot.data[0][plot.cursor.idx] ?? null)),
        ],
        setSelect: [(plot) => this.selected(plot)],
        ready: [(plot) => this.listen(plot)],
      },
    };
  }

  private label(tick: number): string {
    return this.settings.logarithmic ? decade(tick) : plain(tick);
  }

  private range(low: number | null, high: number | null): [number, number] {
    if (this.settings.tight) return rangeOf([[low, high]]);
    const [least, most] = this.settings.atLeast ?? [0, 1e-6];
    let [from, to] = [
      Math.min(Math.max(low ?? least, -this.most), least),
      Math.max(Math.min(high ?? most, this.most), most),
    ];
    const room = (to - from) * 0.06;
    to += room;
    from = this.settings.fromZero ? 0 : from - room;
    return [from, to];
  }

  /** Choose a time by a press, unless the press became a drag. */
  private listen(plot: uPlot): void {
    const pick = this.handlers.pick;
    if (!pick) return;
    let pressed = 0;
    plot.over.addEventListener("pointerdown", (event) => (pressed = event.clientX));
    plot.over.addEventListener("pointerup", (event) => {
      if (Math.abs(event.clientX - pressed) < 4) pick(plot.posToVal(event.offsetX, "x"));
    });
  }

  private selected(plot: uPlot): void {
    const { left, width } = plot.select;
    if (width < 4) return;
    this.handlers.select?.(plot.posToVal(left, "x"), plot.posToVal(left + width, "x"));
    plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
  }

  private behind(plot: uPlot): void {
    const { ctx, bbox } = plot;
    const { seen, accent } = readTokens();
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    if (this.settings.band && !this.element.classList.contains("unknown")) {
      const [low, high] = this.settings.band.map((value) => plot.valToPos(value, "y", true)) as [number, number];
      ctx.fillStyle = faded(seen, 0.18);
      ctx.fillRect(bbox.left, high, bbox.width, low - high);
    }
    if (this.settings.expected !== undefined) across(plot, this.settings.expected, seen);
    if (this.marks.from !== null && this.marks.to !== null) {
      const [left, right] = [this.marks.from, this.marks.to].map((time) => plot.valToPos(time, "x", true));
      ctx.fillStyle = faded(accent, 0.16);
      ctx.fillRect(left ?? 0, bbox.top, (right ?? 0) - (left ?? 0), bbox.height);
    }
    ctx.restore();
  }

  private before(plot: uPlot): void {
    const { accent, ink } = readTokens();
    for (const time of this.marks.events) upright(plot, time, faded(accent, 0.6), 1);
    for (const time of [this.marks.from, this.marks.to]) if (time !== null) upright(plot, time, accent, 1.5);
    if (this.marks.now !== null) upright(plot, this.marks.now, ink, 1.5);
  }

  /** Write the values of one time into the heading. */
  private read(time: number | null): void {
    const times = this.plot?.data[0];
    if (time === null || !times?.length) {
      this.reading.value = "";
      return;
    }
    const row = rowAt(times, time);
    const { lines, each, unit } = this.settings;
    const read = each ? lines.flatMap((line, k) => (line.label ? [k] : [])) : [0];
    if (read.length === 1) {
      const value = this.written(row, (read[0] ?? 0) + 1);
      this.reading.value = value === null ? "" : `${value} ${unit}`;
      return;
    }
    const shown = read.flatMap((k) => this.underlined(this.written(row, k + 1), lines[k]?.color() ?? ""));
    this.reading.replaceChildren(...shown, shown.length && unit ? ` ${unit}` : "");
  }

  private underlined(value: string | null, color: string): HTMLElement[] {
    if (value === null) return [];
    const element = document.createElement("span");
    element.textContent = value;
    element.style.borderColor = color;
    return [element];
  }

  /** A value as it is read; null where it is not known. Where other lines alone have a time, the one before counts. */
  private written(row: number, column: number): string | null {
    const values: Column = (this.plot.data as unknown as Column[])[column] ?? [];
    let at = row;
    while (at > 0 && values[at] === undefined) at -= 1;
    const value = values[at];
    // What rounds to zero has no sign.
    return typeof value === "number" ? value.toFixed(this.settings.digits ?? 3).replace(/^-(?=[0.]*$)/, "") : null;
  }
}

/** Size of the largest value. */
function largest(values: Column): number {
  return values.reduce((most: number, value) => Math.max(most, Math.abs(value ?? 0)), 0);
}

/** Colours of what is no line, as they are now. */
export function inkNow(): Ink {
  const { paper, ink, hair } = readTokens();
  return { paper, text: ink, grid: hair };
}

function series(line: Line): uPlot.Series {
  return {
    stroke: () => line.color(),
    width: line.width ?? 1.25,
    points: { show: false },
    spanGaps: false,
    ...(line.dash ? { dash: line.dash } : {}),
  };
}

function bands(line: Line, k: number): uPlot.Band[] {
  if (line.fillTo === undefined) return [];
  return [{ series: [line.fillTo, k + 1], fill: () => line.fill?.() ?? "transparent" }];
}

/** A number without rounding errors; those of large numbers stay distinct. */
function plain(value: number | null): string {
  return value === null ? "" : String(Number(value.toPrecision(12)));
}
