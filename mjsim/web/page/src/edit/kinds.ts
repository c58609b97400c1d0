/** What kinds of things are called. */

import type { Item } from "../api";

/** Lists of a world, in the order in which they are told, and what a heading over their things says. */
export const HEADINGS: Record<string, string> = {
  walls: "Walls",
  obstacles: "Obstacles",
  beacons: "Beacons",
  lamps: "Lamps",
  robots: "Robots",
  mechanisms: "Mechanisms",
  people: "People",
  floor: "Patches of floor",
};

/** What one thing is: "Wall", "Box", "Patch of floor". */
export function kindName(item: Item): string {
  if (item.type === "FloorPatch") return "Patch of floor";
  const words = item.type.replace(/Obstacle$/, "") || item.kind;
  return words.charAt(0).toUpperCase() + words.slice(1).toLowerCase();
}
