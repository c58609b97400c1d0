/** Things copied and pasted as text of a world, through the clipboard of the system. */

import type { Values } from "../api";

/** Something of a world: the key of its list there, and itself as it is written. */
export interface Piece {
  list: string;
  value: Values;
}

/** Words that stand for no text in YAML when they have no quotes. */
const NO_TEXT = /^(true|false|null|yes|no|on|off|y|n)$/i;
/** Text that needs no quotes. */
const PLAIN = /^[A-Za-z_./][\w./-]*$/;
const LIST = /^(walls|obstacles|beacons|robots|lamps|mechanisms|people|floor):\n((?: {2}- .*\n?)+)$/;

/** Things as text of a world: each below the key of its list. */
export function written(pieces: Piece[]): string {
  const lists = [...new Set(pieces.map(({ list }) => list))];
  const lines = lists.flatMap((list) => {
    const own = pieces.filter((piece) => piece.list === list).map(({ value }) => inline(value));
    return list === "floor"
      ? ["floor:", "  patches:", ...own.map((item) => `    - ${item}`)]
      : [`${list}:`, ...own.map((item) => `  - ${item}`)];
  });
  return lines.map((line) => `${line}\n`).join("");
}

/** What is put into a text at a line of the same list: the items alone. */
export function withoutList(pasted: string, linesAbove: string[]): string {
  const [, list, items] = LIST.exec(pasted) ?? [];
  const around = linesAbove.findLast((line) => /^[^\s#-]/.test(line));
  return items && around?.startsWith(`${list}:`) ? items : pasted;
}

function inline(value: unknown): string {
  if (Array.isArray(value)) return `[${value.map(inline).join(", ")}]`;
  if (typeof value === "string") return PLAIN.test(value) && !NO_TEXT.test(value) ? value : JSON.stringify(value);
  if (typeof value !== "object" || value === null) return String(value);
  return `{${Object.entries(value)
    .map(([key, item]) => `${inline(key)}: ${inline(item)}`)
    .join(", ")}}`;
}
