/** What kinds of things are called. */

import type { Item } from "../api";
import { isWindow } from "../plan/geometry";
import { word, wordFor } from "../words/words";

/** Lists of a world, in the order in which they are told, and what a heading over their things says. */
export const HEADINGS: Record<string, string> = {
  walls: word("edit.walls"),
  obstacles: word("edit.obstacles"),
  beacons: word("edit.beacons"),
  lamps: word("edit.lamps"),
  robots: word("edit.robots"),
  mechanisms: word("edit.mechanisms"),
  people: word("edit.people"),
  floor: word("edit.patchesOfFloor"),
};

/** What one thing is: "Wall", "Box", "Patch of floor". */
export function kindName(item: Item): string {
  if (item.kind === "opening") return word(isWindow(item) ? "edit.window" : "edit.doorway");
  return wordFor("form", item.type);
}
