/** Messages as rows of a table: the path of each value, and the value. */

/** Of longer lists so many values are shown. */
const SHOWN = 8;

/** Path and text of each value of a message; a list of plain values is one row. */
export function* cellsOf(value: unknown, name = ""): Generator<[name: string, text: string]> {
  if (Array.isArray(value) && !value.some((each) => typeof each === "object" && each !== null))
    yield [name, listed(value)];
  else if (Array.isArray(value))
    for (const [k, each] of value.entries()) yield* cellsOf(each, `${name}[${nameOf(each) ?? k}]`);
  else if (typeof value === "object" && value !== null)
    for (const [key, each] of Object.entries(value)) yield* cellsOf(each, name ? `${name}.${key}` : key);
  else if (name) yield [name, plain(value)];
}

/** The unit of a number: its own, or that of what it is part of. */
export function unitOf(name: string, units: Record<string, string>): string {
  const parts = name.replaceAll(/\[[^\]]*\]/g, "").split(".");
  for (let k = parts.length; k > 0; k--) {
    const unit = units[parts.slice(0, k).join(".")];
    if (unit) return unit;
  }
  return "";
}

function listed(values: unknown[]): string {
  const some = values.slice(0, SHOWN).map(plain).join(", ");
  return values.length > SHOWN ? `[${some}, …] (${values.length})` : `[${some}]`;
}

function plain(value: unknown): string {
  if (typeof value !== "number" || Number.isInteger(value)) return String(value ?? "–");
  return String(Number(value.toPrecision(6)));
}

/** Beacons, joints and parts of the loop are known by name. */
function nameOf(value: unknown): string | null {
  const { name, part } = (value ?? {}) as { name?: unknown; part?: unknown };
  return typeof name === "string" ? name : typeof part === "string" ? part : null;
}
