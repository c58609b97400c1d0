/** What the server tells of runs that are compared. */

import { type Bounds, getJson, type Item, type Point } from "../api";
import type { Line } from "../charts/chart";
import { ROW_COLORS, rowColor } from "../ui/ink";

type Values = (number | null)[];

export interface TimeLine {
  time: number[];
  values: Values;
  /** Where nine of ten runs lie, of a line that is their median. */
  low?: Values;
  high?: Values;
  /** Of the one run whose line it is. */
  seed?: number;
}

export interface RunPath {
  seed: number;
  time: number[];
  truth: Partial<Point>[];
  estimate: Partial<Point>[];
}

/** A robot in all runs that differ only in their seed. */
export interface Group {
  label: string;
  runs: number;
  errors: TimeLine[];
  nees: TimeLine;
  /** Whether an estimator gave an estimate; else it is dead reckoning, which has no NEES. */
  estimated: boolean;
  /** Of some of its runs; of none where no path was kept. */
  paths: RunPath[];
}

export interface Difference {
  figure: string;
  /** What the figure is called. */
  title: string;
  unit: string;
  first: string;
  second: string;
  pairs: number;
  mean: number | null;
  low: number | null;
  high: number | null;
  verdict: string;
  reason: string;
}

export interface Comparison {
  groups: Group[];
  scene: { items: Item[]; bounds: Bounds } | null;
  nees: { expected: number; band: [number, number] };
  /** What the cells of the table of means hold. */
  cells: string;
  means: string[][];
  /** Better, than, in, by, pairs. */
  certain: string[][];
  know: string[];
  /** Keys of figures by what they are called in these tables. */
  keys: Record<string, string>;
  differences: Difference[];
  /** `table.csv` of `mjsim compare`. */
  csv: string;
}

export function compare(paths: string[]): Promise<Comparison> {
  return getJson(`/api/compare?${new URLSearchParams(paths.map((path) => ["path", path]))}`);
}

/** How the lines of group k of so many look: later ones are thinner, so that equal lines all show; those beyond the colours are dashed. */
export function styleOf(k: number, count: number): Pick<Line, "color" | "dash"> & { width: number } {
  const width = 2.4 - (1.2 * k) / Math.max(count - 1, 1);
  return { color: () => rowColor(k), width, ...(k >= ROW_COLORS ? { dash: [7, 4] } : {}) };
}
