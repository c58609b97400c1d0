/** What is told beside the pointer while something is dragged. */

import type { Item } from "../api";
import { distance } from "../plan/geometry";
import { word } from "../words/words";
import { cornersOf } from "./shapes";

/** The size that a thing has now, or the length of the wall up to a corner. */
export function sizeNote(ghost: Item, corner: number | undefined): string {
  const points = cornersOf(ghost);
  if (corner !== undefined) {
    const [now, before] = [points[corner], points[corner - 1] ?? points[corner + 1]];
    return now && before ? word("edit.distance", { metres: distance(now, before).toFixed(2) }) : "";
  }
  const value = ["box", "ramp", "steps", "size", "cylinder", "sphere", "width"]
    .map((key) => ghost.values[key])
    .find((size) => size !== undefined);
  return Array.isArray(value) ? `${value.slice(0, 2).join(" × ")} m` : `${String(value)} m`;
}

/** A shift with its sign [m]. */
export function signed(value: number): string {
  return `${value < 0 ? "−" : "+"}${Math.abs(value).toFixed(2)}`;
}
