/** Layouts of plots by their names, as the browser keeps them: which numbers are drawn in which chart. */

import { remembered } from "../ui/controls";
import { word } from "../words/words";

/** Topic and the number's place in its messages. */
export type Field = [topic: string, name: string];
export type PlotKind = "time" | "xy";

export interface PlotChart {
  kind: PlotKind;
  /** Of x against y the first one is x. */
  fields: Field[];
  /** Both axes have one scale, as paths on a floor want it. */
  equal?: boolean;
}

export interface Layout {
  name: string;
  charts: PlotChart[];
}

/** So many numbers are drawn in one chart, so many charts are in a layout, and so many layouts are kept. */
export const MOST = { fields: 6, charts: 8, layouts: 40 };
const FIRST = word("charts.firstLayout");

export class Layouts {
  all: Layout[];
  private chosen: string;

  constructor(private readonly key: string) {
    const { all, chosen } = read(remembered(key));
    this.all = all;
    this.chosen = chosen;
  }

  /** The one that is shown. */
  get now(): Layout {
    return this.all.find(({ name }) => name === this.chosen) ?? this.all[0] ?? { name: FIRST, charts: [empty()] };
  }

  choose(name: string): void {
    this.chosen = name;
    this.keep();
  }

  /** Begin an empty one; says why not where it cannot be. */
  add(name: string): string | null {
    const wrong = this.refused(name);
    if (wrong) return wrong;
    this.all.push({ name, charts: [empty()] });
    this.choose(name);
    return null;
  }

  rename(name: string): string | null {
    if (name === this.now.name) return null;
    const wrong = this.refused(name, 0);
    if (wrong) return wrong;
    this.now.name = name;
    this.choose(name);
    return null;
  }

  remove(): void {
    this.all = this.all.filter((layout) => layout !== this.now);
    if (!this.all.length) this.all = [{ name: FIRST, charts: [empty()] }];
    this.choose(this.all[0]?.name ?? FIRST);
  }

  keep(): void {
    remembered(this.key, JSON.stringify({ chosen: this.chosen, layouts: this.all }));
  }

  /** Return why a layout cannot have a name, or null; `more` is how many layouts this would add. */
  private refused(name: string, more = 1): string | null {
    if (!name) return word("charts.giveTheLayoutA");
    if (this.all.some((layout) => layout.name === name)) return word("charts.thereIsALayout", { name });
    const fits = this.all.length + more <= MOST.layouts;
    return fits ? null : word("charts.layoutsAreKeptRemove", { layouts: MOST.layouts });
  }
}

export function titleOf([topic, name]: Field): string {
  return `${topic}.${name}`;
}

export function empty(): PlotChart {
  return { kind: "time", fields: [] };
}

interface Kept {
  chosen?: unknown;
  layouts?: unknown;
}

/** Take up what was kept; what is no layout, written by another version or by hand, is left out. */
function read(text: string | null): { all: Layout[]; chosen: string } {
  const { layouts, chosen } = parsed(text);
  const all = (Array.isArray(layouts) ? (layouts as unknown[]) : []).filter(isLayout).slice(0, MOST.layouts);
  for (const layout of all) if (!layout.charts.length) layout.charts.push(empty());
  if (!all.length) all.push({ name: FIRST, charts: [empty()] });
  return { all, chosen: all.find(({ name }) => name === chosen)?.name ?? all[0]?.name ?? FIRST };
}

function parsed(text: string | null): Kept {
  try {
    return (JSON.parse(text ?? "{}") as Kept | null) ?? {};
  } catch {
    // What cannot be read is as if nothing had been kept.
    return {};
  }
}

function isLayout(value: unknown): value is Layout {
  const { name, charts } = (value ?? {}) as Partial<Layout>;
  return typeof name === "string" && Array.isArray(charts) && charts.length <= MOST.charts && charts.every(isChart);
}

function isChart(value: unknown): value is PlotChart {
  const { kind, fields } = (value ?? {}) as Partial<PlotChart>;
  const known = (kind === "time" || kind === "xy") && Array.isArray(fields) && fields.length <= MOST.fields;
  return (
    known &&
    fields.every(
      (field) => Array.isArray(field) && field.length === 2 && field.every((part) => typeof part === "string"),
    )
  );
}
