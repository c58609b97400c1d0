/** How high a thing is: the key of the text that says so, and what lifting makes of it. */

import type { Item } from "../api";
import { short } from "../plan/geometry";
import type { Changed } from "./shapes";

/** Nothing with a height hangs lower than this above the floor [m]. */
const LEAST_HEIGHT = 0.01;

/** The key that says how high an item is, and the least it may say [m]; null when nothing says so. */
function liftOf(item: Item): { key: string; least: number } | null {
  const has = (key: string): boolean => typeof item.values[key] === "number";
  if (item.type === "Lamp" && has("height")) return { key: "height", least: LEAST_HEIGHT };
  if (item.type === "Beacon" && has("center")) return { key: "center", least: 0 };
  if (!has("elevation")) return null;
  return { key: "elevation", least: item.type === "Mechanism" ? -Infinity : 0 };
}

export function canLift(item: Item): boolean {
  return liftOf(item) !== null;
}

/** How high the text says that an item is [m]. */
export function heightOf(item: Item): number {
  const lift = liftOf(item);
  return lift ? Number(item.values[lift.key]) : 0;
}

/** Lift an item by metres, to a multiple of the step [m]. */
export function lifted(item: Item, by: number, step: number): Changed {
  const lift = liftOf(item);
  if (!lift) return { ghost: item, changes: [] };
  const value = short(Math.max(Math.round((heightOf(item) + by) / step) * step, lift.least));
  const ghost = { ...item, values: { ...item.values, [lift.key]: value } };
  return { ghost, changes: [{ op: "set", path: [...item.path, lift.key], value }] };
}
