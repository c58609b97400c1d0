/** Fields of several selected things: common values, and changes of all of them. */

import type { Change, Item, Path, Values } from "../api";
import { isMapping, isSame } from "./changes";
import type { Subject } from "./rows";

/** Marks values that differ between the things. */
export const SEVERAL = Symbol("several");

/** Return the subject of the rows of several things; values that differ are `SEVERAL` and not shown as written. */
export function common(items: Item[]): Subject {
  const [first] = items;
  if (!first) return { path: [], values: {}, raw: undefined, written: [], fixed: true };
  const values = shared(items.map((item) => item.values)) as Values;
  const written = first.written.filter((key) => items.every((item) => isSame(item.values[key], first.values[key])));
  return { path: first.path, values, raw: undefined, written, fixed: items.some((item) => item.fixed !== null) };
}

/** Return a change for another item, which keeps its own values where they differ. */
export function retold(change: Change, from: Item | undefined, to: Item): Change {
  if (!from) return change;
  const inner = change.path.slice(from.path.length);
  const path = [...to.path, ...inner];
  if (change.op !== "set") return { ...change, path };
  return { ...change, path, value: own(change.value, at(to.values, inner)) };
}

/** Return a value with the thing's own values in place of those that differ. */
function own(value: unknown, ofThing: unknown): unknown {
  if (value === SEVERAL) return ofThing;
  if (!Array.isArray(value)) return value;
  const values: unknown[] = Array.isArray(ofThing) ? ofThing : [];
  return value.map((each, k): unknown => own(each, values[k]));
}

/** Return the common part of values, element by element and key by key. */
function shared(values: unknown[]): unknown {
  const [first, ...others] = values;
  if (others.every((other) => isSame(other, first))) return first;
  if (values.every((each) => Array.isArray(each) && each.length === (first as unknown[]).length))
    return (first as unknown[]).map((_, k) => shared(values.map((each) => (each as unknown[])[k])));
  if (!values.every(isMapping)) return SEVERAL;
  const keys = Object.keys(first as Values);
  return Object.fromEntries(keys.map((key) => [key, shared(values.map((each) => (each as Values)[key]))]));
}

function at(value: unknown, path: Path): unknown {
  return path.reduce<unknown>((inner, key) => (inner as Values | null | undefined)?.[key], value);
}
