/** Numbers as the fields of a form show and read them. */

/** Smaller numbers are rounding errors. */
const NOTHING = 1e-12;

/** Format a value: numbers to four decimals, small ones, such as inertias, to four significant digits. */
export function shown(value: unknown): string {
  if (value === null || value === undefined) return "–";
  if (typeof value !== "number") return String(value);
  const size = Math.abs(value);
  return size < NOTHING ? "0" : String(Number(size < 0.1 ? value.toPrecision(4) : value.toFixed(4)));
}

/** A number, or arithmetic such as ${width / 2}; undefined when it is neither: a comma may separate decimals or thousands. */
export function readNumber(text: string): number | string | undefined {
  if (text.includes("${")) return text;
  const value = Number(text.replace("−", "-"));
  return text === "" || !Number.isFinite(value) ? undefined : value;
}

/** The number of a field a step further, where the key is an arrow up or down, with Shift a tenth of it; else null. */
export function stepped(
  text: string,
  { key, shiftKey }: Pick<KeyboardEvent, "key" | "shiftKey">,
  step: number,
): string | null {
  const sign = { ArrowUp: 1, ArrowDown: -1 }[key];
  const now = Number(text);
  if (!sign || !Number.isFinite(now)) return null;
  return String(Number((now + sign * step * (shiftKey && step < 1 ? 0.1 : 1)).toFixed(4)));
}
