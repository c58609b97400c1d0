/** Colours, sizes and decay that a person has chosen for what is drawn of runs, everywhere alike; the browser keeps them. */

import { remembered } from "./controls";
import { themeChanged } from "./theme";

/** Tokens of theme.css with a colour of one's own, and factors of sizes, by the name of what is drawn. */
interface Chosen {
  colors: Record<string, string>;
  sizes: Record<string, number>;
  /** Seconds for which it stays. */
  decays: Record<string, number>;
}

const KEY = "displays";
/** Factors of sizes. */
export const [LEAST, MOST] = [0.5, 4];
/** [s] */
export const LONGEST_DECAY = 600;
const chosen = read();
paint();

/** Use a colour '#rrggbb' for a token of theme.css, such as "--truth"; null for that of the theme. */
export function chooseColor(token: string, rgb: string | null): void {
  if (rgb) chosen.colors[token] = rgb;
  else delete chosen.colors[token];
  document.documentElement.style.removeProperty(token);
  keep();
}

/** Draw something so many times as large. */
export function chooseSize(name: string, factor: number): void {
  chosen.sizes[name] = factor;
  keep();
}

/** How many times as large as usual something is drawn. */
export function sizeOf(name: string): number {
  return chosen.sizes[name] ?? 1;
}

/** Let something stay for so many seconds; null for as long as usual. */
export function chooseDecay(name: string, seconds: number | null): void {
  if (seconds === null) delete chosen.decays[name];
  else chosen.decays[name] = seconds;
  keep();
}

/** For how many seconds something stays, if a person has chosen that. */
export function decayOf(name: string): number | null {
  return chosen.decays[name] ?? null;
}

function keep(): void {
  remembered(KEY, JSON.stringify(chosen));
  paint();
  themeChanged.emit();
}

function paint(): void {
  for (const [token, rgb] of Object.entries(chosen.colors)) document.documentElement.style.setProperty(token, rgb);
}

/** What was kept; what cannot be read is as if nothing had been. */
function read(): Chosen {
  try {
    const { colors, sizes, decays } = JSON.parse(remembered(KEY) ?? "{}") as Partial<Chosen>;
    const rgb = Object.entries(colors ?? {}).filter(([, value]) => /^#[0-9a-f]{6}$/.test(value));
    const factors = Object.entries(sizes ?? {}).filter(([, value]) => value >= LEAST && value <= MOST);
    const seconds = Object.entries(decays ?? {}).filter(([, value]) => value >= 0 && value <= LONGEST_DECAY);
    return {
      colors: Object.fromEntries(rgb),
      sizes: Object.fromEntries(factors),
      decays: Object.fromEntries(seconds),
    };
  } catch {
    return { colors: {}, sizes: {}, decays: {} };
  }
}
