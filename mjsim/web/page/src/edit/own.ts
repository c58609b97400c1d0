/** What is written in the text itself of events, drivers and plants; included files have others. */

import type { Path, Values } from "../api";
import type { WorldDocument } from "../shell/document";

/** Keys of events whose value is the name of a thing. */
export const NAMING = [
  "move",
  "open",
  "close",
  "lamp",
  "remove",
  "restore",
  "shove",
  "push",
  "reach",
  "release",
  "lead",
  "goal",
];

/** Something in a list of the text itself, and its path. */
export type Own = [path: Path, value: Values];

/** Events that are written in the text itself. */
export function ownEvents(document: WorldDocument): Own[] {
  return ownIn(["run", "events"], run(document)["events"], document.parsed.run["events"]);
}

/** Plants that are written in the text itself. */
export function ownPlants({ parsed: { world } }: WorldDocument): Own[] {
  return ownIn(["plants"], world?.raw?.["plants"], world?.values["plants"]);
}

/** Drivers that are written in the text itself, by their robots. */
export function ownDrivers(document: WorldDocument): Record<string, Values> {
  return (run(document)["drivers"] ?? {}) as Record<string, Values>;
}

function run({ parsed: { world } }: WorldDocument): Values {
  return (world?.raw?.["run"] ?? {}) as Values;
}

/** What a list of the text has of a list of the world, where that of included files comes first. */
function ownIn(path: Path, written: unknown, all: unknown): Own[] {
  if (!Array.isArray(written)) return [];
  const before = Array.isArray(all) ? all.length - written.length : 0;
  // Where some are repeated, nobody knows which is which.
  if (before < 0 || written.some((one: unknown) => typeof one !== "object" || one === null || "repeat" in one))
    return [];
  return written.map((one: Values, k): Own => [[...path, before + k], one]);
}
