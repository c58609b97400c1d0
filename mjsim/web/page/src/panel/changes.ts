/** What changes make of values, and which changes make one value of another. Nothing is written here. */

import type { Change, Path, Values } from "../api";

/** A value with changes in it, as the server would write them; mappings and lists on the way are put in. */
export function applied(value: unknown, changes: Change[]): unknown {
  return changes.reduce(changed, value);
}

/** The fewest changes at a path that make one value of another; another module is written as a whole. */
export function differences(path: Path, before: unknown, after: unknown): Change[] {
  if (isSame(before, after)) return [];
  if (after === undefined) return [{ op: "unset", path }];
  if (!isMapping(before) || !isMapping(after) || before["use"] !== after["use"])
    return [{ op: "set", path, value: after }];
  const keys = [...new Set([...Object.keys(before), ...Object.keys(after)])];
  return keys.flatMap((key) => differences([...path, key], before[key], after[key]));
}

export function isSame(one: unknown, other: unknown): boolean {
  return JSON.stringify(one) === JSON.stringify(other);
}

function changed(value: unknown, change: Change): unknown {
  if (change.op === "set") return at(value, change.path, () => change.value);
  if (change.op === "add")
    return at(value, change.path, (list) => [...(Array.isArray(list) ? (list as unknown[]) : []), change.value]);
  return change.op === "unset" || change.op === "remove" ? at(value, change.path, () => undefined) : value;
}

/** A value with another one at a path of it; undefined takes away what is there. */
function at(value: unknown, [key, ...deeper]: Path, fresh: (old: unknown) => unknown): unknown {
  if (key === undefined) return fresh(value);
  if (Array.isArray(value))
    return value
      .map((each, k): unknown => (k === key ? at(each, deeper, fresh) : each))
      .filter((each) => each !== undefined);
  const has = isMapping(value) ? value : {};
  const { [key]: old, ...rest } = has;
  const inner = at(old, deeper, fresh);
  if (inner === undefined) return isMapping(value) ? rest : value;
  return key in has ? { ...has, [key]: inner } : { ...rest, [key]: inner };
}

export function isMapping(value: unknown): value is Values {
  return typeof value === "object" && value !== null && !Array.isArray(value);
}
