/** Colours of what is drawn on canvases, as the theme has them now. */

import { color, themeChanged } from "./theme";

const NAMES = [
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
  "lamp",
  "muted",
  "odometry",
  "paper",
  "ranged",
  "scanned",
  "seen",
  "touched",
  "truth",
  "wall",
  "wall-low",
  "warning",
] as const;
/** Of modules and other rows of a chart; told apart by those who do not see all colours. */
const ROWS = ["--truth", "--estimate", "--seen", "--scanned", "--beacon", "--odometry"];

/** So many rows of a chart have a colour of their own. */
export const ROW_COLORS = ROWS.length;

export type Tokens = Record<(typeof NAMES)[number], string>;

let tokens: Tokens | null = null;
themeChanged.on(() => {
  tokens = null;
});

/** Return the colours of now. */
export function readTokens(): Tokens {
  tokens ??= Object.fromEntries(NAMES.map((name) => [name, color(`--${name}`)])) as Tokens;
  return tokens;
}

/** Do something with the colours of the light theme: for what is put on white paper. */
export function inLight<T>(work: () => T): T {
  const { dataset } = document.documentElement;
  const kept = dataset["theme"];
  dataset["theme"] = "light";
  tokens = null;
  try {
    return work();
  } finally {
    dataset["theme"] = kept;
    tokens = null;
  }
}

/** Return the colour of row k of a chart. */
export function rowColor(k: number): string {
  return color(ROWS[k % ROWS.length] ?? "--muted");
}

/** Return the row whose colour a quantity has everywhere, -1 if it has none of its own. */
export function rowNamed(quantity: string): number {
  return ["truth", "estimate", "odometry"].includes(quantity) ? ROWS.indexOf(`--${quantity}`) : -1;
}

/** The same colour '#rrggbb', part of which lets through what is behind it. */
export function faded(rgb: string, share: number): string {
  const alpha = Math.round(255 * share);
  return rgb + alpha.toString(16).padStart(2, "0");
}
