/** An axis that is logarithmic beyond 1: where it has its lines, and what they are called. */

import type uPlot from "uplot";

/** Powers of one axis at most. */
const MOST = 4;

/** Lines at decades; those of the library are at each multiple of them, and too many to be read. */
export const LOGARITHMIC: uPlot.Axis = {
  splits: (_plot, _axis, _low, high) => decades(high),
  filter: (_plot, splits) => splits,
};

/** Powers of ten up to a value, and 0 where there is room below them: so few that each can be read. */
function decades(high: number): number[] {
  const last = Math.floor(Math.log10(Math.max(high, 1)));
  const step = Math.ceil((last + 1) / MOST);
  const powers = Array.from({ length: Math.floor(last / step) + 1 }, (_, k) => 10 ** (k * step));
  return step === 1 ? [0, ...powers] : powers;
}

/** A power of ten, as short as it can be. */
export function decade(value: number): string {
  return value < 1e4 ? String(value) : `1e${Math.round(Math.log10(value))}`;
}
