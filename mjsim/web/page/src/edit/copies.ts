/** Items that are added to a world: unused names, and copies beside their originals. */

import type { Item, Point, Values } from "../api";
import { short } from "../plan/geometry";
import { withLinks } from "./links";

/** Numbers of markers in the dictionaries 4x4_50, 4x4_100 and so on. */
const SIZES = [50, 100, 250, 1000] as const;
/** Maximum length of a name. */
const LONGEST = 64;

/** Return an unused name: the wish, or the wish with a number. `behind` is the suffix of the first repetition. */
export function freshName(wish: string, taken: ReadonlySet<string>, behind = ""): string {
  const plain = wish
    .normalize("NFC")
    .replace(/[^\p{L}\p{M}\p{N}_.-]/gu, "-")
    .replace(/^[^\p{L}\p{N}_]+/u, "");
  const base = plain.slice(0, LONGEST - behind.length) || "thing";
  const stem = base.replace(/-\d+$/, "");
  for (let number = 1; ; number++) {
    const end = `-${number}`;
    const name = number === 1 ? base : stem.slice(0, LONGEST - behind.length - end.length) + end;
    if (!taken.has(name) && !taken.has(name + behind)) return name;
  }
}

/** Return a thing and its openings under unused names, and add these to `taken`. */
export function renamed(value: Values, taken: Set<string>): Values {
  const fresh = { ...value };
  const { name, openings } = fresh;
  // The text itself makes names that contain expressions.
  if (typeof name === "string" && !name.includes("${"))
    taken.add((fresh["name"] = freshName(name, taken, fresh["repeat"] ? "-1" : "")));
  if (Array.isArray(openings)) fresh["openings"] = openings.map((one: Values) => renamed(one, taken));
  return fresh;
}

/** Return the first unused marker, and a name for a beacon with it. */
export function freshMarker(items: Item[]): { name: string; marker: Values } {
  const taken = new Set(items.map(markerId));
  const id = [...taken, null].findIndex((_, each) => !taken.has(each));
  // Each dictionary begins with the markers of the smaller ones.
  const size = SIZES.find((each) => id < each) ?? SIZES[0];
  return { name: `tag${id}`, marker: { dictionary: `4x4_${size}`, id: id % size } };
}

/** Return a new item with another marker if an item has its marker already. */
export function remarked(value: Values, items: Item[]): Values {
  const id = markerId({ values: value });
  return id !== undefined && items.some((item) => markerId(item) === id) ? { ...value, ...freshMarker(items) } : value;
}

function markerId({ values }: Pick<Item, "values">): unknown {
  return (values["marker"] as Values | null | undefined)?.["id"];
}

/** Return copies under unused names, shifted by `by` [m]; things mounted on a copied thing are mounted on its copy. */
export function copied(things: Values[], by: Point, taken: Set<string>): Values[] {
  const fresh = things.map((thing) => renamed(thing, taken));
  const names = new Map<string, string>();
  for (const [k, { name }] of things.entries()) {
    if (typeof name === "string") names.set(name, String(fresh[k]?.["name"]));
  }
  return fresh.map((copy) => withLinks(names.has(String(copy["on"])) ? copy : beside(copy, by), names));
}

/** Return an item as it is written in the text, without its repetition. */
export function asWritten(item: Item): Values {
  const { repeat: _, ...raw } = item.raw ?? Object.fromEntries(item.written.map((key) => [key, item.values[key]]));
  return structuredClone(raw);
}

function beside(thing: Values, [dx, dy]: Point): Values {
  const shift = (point: unknown): unknown =>
    Array.isArray(point) && typeof point[0] === "number" && typeof point[1] === "number"
      ? [short(point[0] + dx), short(point[1] + dy), ...point.slice(2)]
      : point;
  const fresh: Values = { ...thing };
  if ("at" in fresh) fresh["at"] = shift(fresh["at"]);
  if (Array.isArray(fresh["points"])) fresh["points"] = fresh["points"].map(shift);
  return fresh;
}

/** The first that is not used yet, from the current one on and around in its group, then of others; or the current one. */
export function nextUnused(current: string, groups: string[][], used: Set<string>): string {
  const own = groups.find((group) => group.includes(current)) ?? [];
  const at = own.indexOf(current);
  return [...own.slice(at), ...own, ...groups.flat()].find((each) => !used.has(each)) ?? current;
}
