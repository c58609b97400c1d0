/** Values in columns: the row of a time, and what most of them do not exceed. */

const SAMPLE = 800;

/** Index of the last time that is not after a given one. */
export function rowAt(times: ArrayLike<number>, time: number): number {
  let [low, high] = [0, times.length - 1];
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if ((times[middle] ?? 0) <= time) low = middle;
    else high = middle - 1;
  }
  return low;
}

/** The value that a share of those that are known does not exceed; of many, some hundreds are looked at. */
export function quantile(values: readonly (number | null | undefined)[], share: number): number {
  const every = Math.ceil(values.length / SAMPLE);
  const known = values.filter((value, k) => k % every === 0 && typeof value === "number") as number[];
  known.sort((a, b) => a - b);
  return known[Math.floor(share * (known.length - 1))] ?? Number.POSITIVE_INFINITY;
}
