/** What goes with things that are deleted: what is mounted on them, their drivers, events and references that name them. */

import type { Change, Item, Values } from "../api";
import { keyOf } from "../plan/plan";
import type { WorldDocument } from "../shell/document";
import { isMountedOn, unlinked } from "./links";
import { NAMING, ownDrivers, ownEvents, ownPlants } from "./own";

/** Things with the beacons that are mounted on them, which have no place without them. */
export function withMounted(things: Item[], all: Item[]): Item[] {
  const [names, keys] = [new Set(things.map(({ name }) => name)), new Set(things.map(({ path }) => keyOf(path)))];
  return [...things, ...all.filter((item) => !item.fixed && !keys.has(keyOf(item.path)) && isMountedOn(item, names))];
}

/** The changes after which nothing names things that are to be deleted, nor a part of them; they come before that. */
export function forgetting(things: Item[], document: WorldDocument): Change[] {
  const isGone = ({ path }: Item): boolean => things.some((thing) => thing.path.every((step, k) => step === path[k]));
  const names = new Set(document.items.filter(isGone).flatMap(({ name }) => name ?? []));
  const robots = things.filter(({ type, name }) => type === "Robot" && name !== null);
  const drivers = robots.filter(({ name }) => String(name) in ownDrivers(document));
  return [
    ...document.items.flatMap((item) => (item.fixed || isGone(item) ? [] : unlinked(item, names))),
    ...drivers.map(({ name }): Change => ({ op: "unset", path: ["run", "drivers", String(name)] })),
    ...ownEvents(document)
      .flatMap(([path, event]) => (isAbout(event, names, robots) ? [{ op: "remove" as const, path }] : []))
      .reverse(),
    ...ownPlants(document)
      .flatMap(([path, { of }]) => (names.has(String(of).split("/")[0] ?? "") ? [{ op: "remove" as const, path }] : []))
      .reverse(),
  ];
}

/** Whether an event is about one of these names, or about noise of one of these robots. */
function isAbout(event: Values, names: ReadonlySet<string>, robots: Item[]): boolean {
  const noise = String(event["noise"] ?? "");
  const ofRobot = ({ name, path }: Item): boolean =>
    [name, path[1]].some((step) => noise.startsWith(`robots.${step}.`));
  return NAMING.some((key) => names.has(String(event[key]))) || robots.some(ofRobot);
}
