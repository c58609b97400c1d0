/** Things of one group are selected, moved and turned as one; the text says by `group:` which these are. */

import type { Change, Item, Point, Values } from "../api";
import { add, minus, rotate, times } from "../plan/geometry";
import { keyOf } from "../plan/plan";
import { type Changed, canTurn, cornersOf, isJoint, isWall, moved, pivotOf, spun } from "./shapes";

/** The group that a thing is of. */
export function groupOf(item: Item): string | null {
  const group = item.values["group"];
  return typeof group === "string" ? group : null;
}

/** Things, and with each the others of its group. */
export function withGroups(items: Item[], all: Item[]): Item[] {
  const groups = new Set(items.map(groupOf).filter((group) => group !== null));
  if (!groups.size) return items;
  const keys = new Set(items.map(({ path }) => keyOf(path)));
  return [...items, ...all.filter((item) => !keys.has(keyOf(item.path)) && groups.has(groupOf(item) ?? ""))];
}

/** The group that some things are, all of it and nothing else; null when they are none. */
export function wholeGroup(items: Item[], all: Item[]): string | null {
  const group = items[0] ? groupOf(items[0]) : null;
  const isOne = items.length > 1 && items.every((item) => groupOf(item) === group);
  return group !== null && isOne && withGroups(items, all).length === items.length ? group : null;
}

/** Those of some things that can be of a group: what is part of another thing goes with that. */
export function groupable(items: Item[]): Item[] {
  return items.filter((item) => !item.fixed && item.type !== "Opening" && !isJoint(item));
}

/** What makes things a group of a name that no other has. */
export function grouped(items: Item[], all: Item[]): Change[] {
  const value = freshGroup("group-1", new Set(all.flatMap((item) => groupOf(item) ?? [])));
  return groupable(items).map(({ path }): Change => ({ op: "set", path: [...path, "group"], value }));
}

/** What takes things out of their groups. */
export function ungrouped(items: Item[]): Change[] {
  const members = groupable(items).filter((item) => groupOf(item) !== null);
  return members.map(({ path }): Change => ({ op: "unset", path: [...path, "group"] }));
}

/** Things that are put in, of groups that no other thing has; one that is put in alone is of none. */
export function regrouped(values: Values[], all: Item[]): Values[] {
  const taken = new Set(all.flatMap((item) => groupOf(item) ?? []));
  const fresh = new Map<unknown, string>();
  for (const { group } of values) {
    if (typeof group !== "string" || fresh.has(group) || values.filter((other) => other["group"] === group).length < 2)
      continue;
    fresh.set(group, freshGroup(group, taken));
    taken.add(fresh.get(group) ?? "");
  }
  return values.map(({ group, ...others }) => (fresh.has(group) ? { ...others, group: fresh.get(group) } : others));
}

/** A name of a group that is not taken: as wished, or with a number. */
function freshGroup(wish: string, taken: Set<string>): string {
  const stem = wish.replace(/-\d+$/, "");
  if (!taken.has(wish)) return wish;
  for (let number = 2; ; number++) if (!taken.has(`${stem}-${number}`)) return `${stem}-${number}`;
}

/** The middle of where things are, about which a group turns: turned about it, they have the same middle. */
export function middleOf(items: Item[]): Point {
  const sum = items.map(pivotOf).reduce(add, [0, 0]);
  return times(sum, 1 / Math.max(items.length, 1));
}

/** Things turned by degrees: groups that are there as a whole each about its middle, all others each about its own. */
export function turnedAlike(items: Item[], degrees: number, all: Item[]): Changed[] {
  const groups = new Set(items.map(groupOf).filter((group) => group !== null));
  const whole = [...groups]
    .map((group) => items.filter((item) => groupOf(item) === group))
    .filter((one) => wholeGroup(one, all));
  const together = new Set(whole.flat());
  const single = items.filter((item) => !together.has(item));
  return [
    ...whole.flatMap((group) => spunTogether(byThemselves(group), middleOf(group), degrees, all)),
    ...single.map((item) => (canTurn(item) ? spun(item, degrees) : { ghost: item, changes: [] })),
  ];
}

function spunTogether(items: Item[], pivot: Point, degrees: number, all: Item[]): Changed[] {
  return items.map((item) => {
    const own = canTurn(item) ? spun(item, degrees) : { ghost: item, changes: [] };
    const from = isWall(item) ? cornersOf(item)[0] : item.at;
    const to = isWall(item) ? cornersOf(own.ghost)[0] : item.at;
    if (!from || !to) return own;
    const place = add(pivot, rotate(minus(from, pivot), degrees));
    const put = moved(own.ghost, minus(place, to), all);
    // A wall has its corners alone: those of both steps would be written twice.
    return { ghost: put.ghost, changes: isWall(item) ? cornersSet(put.ghost) : [...put.changes, ...own.changes] };
  });
}

function cornersSet(wall: Item): Change[] {
  return cornersOf(wall).map((value, index): Change => ({ op: "set", path: [...wall.path, "points", index], value }));
}

/** Those of some things that are moved by themselves: what hangs on another one of them goes along with that. */
export function byThemselves(items: Item[]): Item[] {
  const names = new Set(items.flatMap(({ name }) => name ?? []));
  return items.filter(({ values }) => typeof values["on"] !== "string" || !names.has(values["on"]));
}
