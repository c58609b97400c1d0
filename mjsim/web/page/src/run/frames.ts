/** Pictures as they come: a head in JSON, then a JPEG, or where bodies are. */

import type { FrameHead } from "./protocol";

/** Take a binary message apart: 4 bytes with the length of the head, the head, the picture. */
export function splitFrame(data: ArrayBuffer): { head: FrameHead; body: ArrayBuffer } {
  const length = new DataView(data).getUint32(0, true);
  const text = new TextDecoder().decode(new Uint8Array(data, 4, length));
  return { head: JSON.parse(text) as FrameHead, body: data.slice(4 + length) };
}

/** Pictures are counted over no less [ms]: the first two may come together. */
const SHORTEST = 500;

/** How many pictures a second were shown, over the last two seconds. */
export class Rate {
  private readonly shown: number[] = [];

  constructor(private readonly span = 2000) {}

  count(now = performance.now()): void {
    this.shown.push(now);
    this.forget(now);
  }

  /** Pictures a second; 0 when there were fewer than two. */
  value(now = performance.now()): number {
    this.forget(now);
    const [first, last] = [this.shown[0], this.shown[this.shown.length - 1]];
    if (first === undefined || last === undefined || last === first) return 0;
    return ((this.shown.length - 1) * 1000) / Math.max(last - first, SHORTEST);
  }

  private forget(now: number): void {
    while (this.shown.length && now - (this.shown[0] ?? now) > this.span) this.shown.shift();
  }
}
