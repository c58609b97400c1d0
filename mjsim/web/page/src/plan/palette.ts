/** Colours of the plan: those of the theme, read anew when it changes. */

import { color } from "../shell/theme";

const TOKENS = [
  "accent",
  "beacon",
  "edge",
  "error",
  "estimate",
  "glass",
  "grid",
  "grid-strong",
  "ground",
  "hair",
  "ink",
  "muted",
  "odometry",
  "paper",
  "seen",
  "truth",
  "wall",
  "wall-low",
  "warning",
] as const;

export type Token = (typeof TOKENS)[number];
export type Palette = Record<Token, string>;

export function readPalette(): Palette {
  return Object.fromEntries(TOKENS.map((token) => [token, color(`--${token}`)])) as Palette;
}

/** A colour '#rrggbb' mixed with a share of another. */
export function blend(one: string, other: string, share: number): string {
  const [a, b] = [channels(one), channels(other)];
  const mixed = a.map((value, index) => Math.round((1 - share) * value + share * (b[index] ?? value)));
  return `rgb(${mixed.join(" ")})`;
}

function channels(text: string): number[] {
  return [1, 3, 5].map((start) => Number.parseInt(text.slice(start, start + 2), 16) || 0);
}
