/** What is drawn where nobody has chosen anything, and no robot drives. */

import type { Field, PlotChart } from "./layouts";

/** How joints move, in a chart for each topic; no more than `most`. */
export function suggested(fields: Field[], most: { fields: number; charts: number }): PlotChart[] {
  const topics = new Map<string, Field[]>();
  for (const field of fields)
    if (/\/joints$/.test(field[0]) && /\.position$/.test(field[1]))
      topics.set(field[0], [...(topics.get(field[0]) ?? []), field]);
  return [...topics.values()]
    .slice(0, most.charts)
    .map((some) => ({ kind: "time", fields: some.slice(0, most.fields) }));
}
