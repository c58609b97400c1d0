/** What goes with a new name: the driver of a robot, what hangs or sits on a thing, and the events that name either. */

import type { Change, Item } from "../api";
import type { WorldDocument } from "../shell/document";
import { followingPart } from "./follow_parts";
import { relinked } from "./links";
import { NAMING, ownDrivers, ownEvents, ownPlants } from "./own";

/** Changes of a world that follow one change; none unless that names a thing, or a part of one, anew. */
export function following(change: Change, document: WorldDocument): Change[] {
  if (change.op !== "set" || typeof change.value !== "string") return [];
  const item = document.itemAt(change.path.slice(0, -1));
  if (!item || change.path.at(-1) !== "name") return followingPart(change.path, change.value, document);
  const old = item.name;
  if (!old || item.raw?.["repeat"] !== undefined) return [];
  const name = change.value;
  const names = new Map([[old, name]]);
  const follow = document.items.flatMap((other) => (other.fixed ? [] : relinked(other, names)));
  if (item.type === "Robot" && old in ownDrivers(document))
    follow.push({ op: "rename", path: ["run", "drivers", old], value: name });
  return [...follow, ...inEvents(document, item, name), ...inPlants(document, old, name)];
}

function inEvents(document: WorldDocument, { name: old, type, path }: Item, name: string): Change[] {
  return ownEvents(document).flatMap(([place, event]) => {
    const named = NAMING.filter((key) => event[key] === old).map(
      (key): Change => ({ op: "set", path: [...place, key], value: name }),
    );
    const noise = event["noise"];
    const begins = `robots.${old}.`;
    // A key cannot go through a name with a dot in it; then the number of the robot stands there.
    const step = name.includes(".") ? String(path[1]) : name;
    if (type === "Robot" && typeof noise === "string" && noise.startsWith(begins))
      named.push({ op: "set", path: [...place, "noise"], value: `robots.${step}.${noise.slice(begins.length)}` });
    return named;
  });
}

/** Plants are of a robot or a mechanism, or of a part: `ROBOT/ARM`. */
function inPlants(document: WorldDocument, old: string, name: string): Change[] {
  return ownPlants(document).flatMap(([place, { of }]): Change[] => {
    const [thing, ...part] = String(of).split("/");
    return thing === old ? [{ op: "set", path: [...place, "of"], value: [name, ...part].join("/") }] : [];
  });
}
