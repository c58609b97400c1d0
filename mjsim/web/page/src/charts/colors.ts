/** Colours of chosen numbers: truth, estimate and odometry have theirs of everywhere, the others follow in order. */

import { ROW_COLORS, rowColor, rowNamed } from "../ui/ink";
import { type Field, titleOf } from "./layouts";

/** Return the colour of field k of a chart as the theme has it; the first of a quantity has its own. */
export function colorsOf(fields: Field[]): (k: number) => string {
  const taken = new Set<number>();
  const own = fields.map((field) => {
    const row = titleOf(field)
      .split(/[./]/)
      .map(rowNamed)
      .find((each) => each >= 0 && !taken.has(each));
    if (row !== undefined) taken.add(row);
    return row;
  });
  const free = Array.from({ length: ROW_COLORS }, (_, row) => row).filter((row) => !taken.has(row));
  let next = 0;
  const rows = own.map((row) => row ?? free[next++ % free.length] ?? 0);
  return (k) => rowColor(rows[k] ?? k);
}
