/** Sliders of noise: where a value stands on them, and what they are called. */

import type { NoiseFigure } from "./protocol";

/** Where the slider ends when the world's own value is 0 and the model says nothing, by unit. */
const MOST: Record<string, number> = { deg: 10, m: 0.3, "1/s": 2 };

/** Values at the ends of a slider; `even` unless small values get more room. */
export interface Span {
  low: number;
  high: number;
  even: boolean;
}

export function spanOf({ initial, unit, slider }: NoiseFigure): Span {
  const [low, high] = [slider?.[0] ?? 0, slider?.[1] ?? MOST[unit ?? ""] ?? 0.2];
  // An error to both sides of a value, or a probability.
  if (low !== 0 || (slider && high === 1)) return { low, high, even: low !== 0 };
  return { low, high: initial ? 8 * initial : high, even: false };
}

/** The value at a share of the slider's way; the square gives small values more room. */
export function valueAt({ low, high, even }: Span, share: number): number {
  return rounded(low + (high - low) * (even ? share : share ** 2));
}

export function shareOf({ low, high, even }: Span, value: number): number {
  const share = Math.min(1, Math.max(0, (value - low) / (high - low)));
  return even ? share : Math.sqrt(share);
}

export function rounded(value: number): number {
  return Number(value.toPrecision(3));
}

/** `robots.scout.odometry.noise.turn` -> `scout, odometry` and `turn`. */
export function splitKey(key: string): [string, string] {
  const parts = key.split(".");
  const last = (parts.pop() ?? key).replace(/_deg$/, "");
  const group = parts.filter((part, k) => part !== "noise" && part !== "sensors" && !(k === 0 && part === "robots"));
  return [group.join(", "), last];
}
