/** What goes with a new name: the driver of a robot, what hangs or sits on a thing, and the events that name either. */

import type { Change, Item, Path, Values } from "../api";
import type { WorldDocument } from "../shell/document";
import { relinked } from "./links";

/** Keys of events whose value is the name of a thing. */
const NAMING = ["move", "open", "close", "lamp", "remove", "restore", "shove", "push", "reach", "release", "lead"];

/** Changes of a world that follow one change; none unless that names a thing anew. */
export function following(change: Change, document: WorldDocument): Change[] {
  if (change.op !== "set" || change.path.at(-1) !== "name" || typeof change.value !== "string") return [];
  const item = document.itemAt(change.path.slice(0, -1));
  const old = item?.name;
  if (!item || !old || item.raw?.["repeat"] !== undefined) return [];
  const name = change.value;
  const names = new Map([[old, name]]);
  const follow = document.items.flatMap((other) => (other.fixed ? [] : relinked(other, names)));
  const drivers = document.parsed.run["drivers"];
  if (item.type === "Robot" && typeof drivers === "object" && drivers !== null && old in drivers)
    follow.push({ op: "rename", path: ["run", "drivers", old], value: name });
  return [...follow, ...inEvents(document, item, name)];
}

/** Changes of the events that are written in the text itself. */
function inEvents(document: WorldDocument, { name: old, type, path }: Item, name: string): Change[] {
  const run = document.parsed.world?.raw?.["run"] as Values | undefined;
  const events = Array.isArray(run?.["events"]) ? (run["events"] as Values[]) : [];
  return events.flatMap((event, index) => {
    const place: Path = ["run", "events", index];
    const named = NAMING.filter((key) => event?.[key] === old).map((key): Change => ({ op: "set", path: [...place, key], value: name }));
    const noise = event?.["noise"];
    const begins = `robots.${old}.`;
    // A key cannot go through a name with a dot in it; then the number of the robot stands there.
    const step = name.includes(".") ? String(path[1]) : name;
    if (type === "Robot" && typeof noise === "string" && noise.startsWith(begins))
      named.push({ op: "set", path: [...place, "noise"], value: `robots.${step}.${noise.slice(begins.length)}` });
    return named;
  });
}
