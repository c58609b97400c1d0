/** Tells when pictures stay too slow though they have the fewest pixels. */

import { Signal } from "../ui/signal";

/** So many pictures a second are wanted, and of so many things so many. */
const QUICK = 20;
const MANY = 500;
const QUICK_OF_MANY = 8;
/** By the median of so many pictures it is found. */
const ENOUGH = 25;

export class Pace {
  /** Told with the pictures a second when they are too few. */
  readonly slow = new Signal<number>();
  private times: number[] = [];

  /** Note how long a picture took [ms]; those with more pixels than the fewest begin anew. */
  add(took: number, { coarsest, things }: { coarsest: boolean; things: number }): void {
    if (!coarsest) this.times = [];
    else if (this.times.push(took) >= ENOUGH) this.judge(things >= MANY ? QUICK_OF_MANY : QUICK);
  }

  private judge(wanted: number): void {
    const rate = 1000 / (this.times.sort((a, b) => a - b)[ENOUGH >> 1] ?? 1);
    this.times = [];
    if (rate < wanted) this.slow.emit(rate);
  }
}
