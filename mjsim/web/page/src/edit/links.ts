/** References between things by name: what a beacon is mounted on, a seat, targets of hands, feet and eyes. */

import type { Change, Item, Path, Values } from "../api";

/** Paths of references within a thing. A target is `THING.TARGET`. */
const LINKS: Path[] = [
  ...[["on"], ["seat"], ["gaze"]],
  ...["hands", "feet"].flatMap((limbs) => [
    [limbs, "left"],
    [limbs, "right"],
  ]),
];

/** Return the changes after which a thing refers to renamed things by their new names. */
export function relinked({ path, raw, values }: Item, names: ReadonlyMap<string, string>): Change[] {
  return LINKS.flatMap((link): Change[] => {
    const fresh = linkAfter(at(raw ?? values, link), names);
    return fresh === null ? [] : [{ op: "set", path: [...path, ...link], value: fresh }];
  });
}

/** Return the changes after which a thing refers to none of some things; a person without its seat stays at its place. */
export function unlinked({ path, raw, values, at: place, heading_deg }: Item, names: ReadonlySet<string>): Change[] {
  const written = raw ?? values;
  return LINKS.flatMap((link): Change[] => {
    const named = at(written, link);
    if (typeof named !== "string" || !(names.has(named) || names.has(named.slice(0, named.lastIndexOf(".")))))
      return [];
    const stands = link[0] === "seat" && place !== null && written["at"] === undefined;
    const posed: Change[] = stands
      ? [
          { op: "set", path: [...path, "at"], value: place },
          { op: "set", path: [...path, "heading_deg"], value: heading_deg ?? 0 },
        ]
      : [];
    return [...posed, { op: "unset", path: [...path, ...link] }];
  });
}

/** Return whether a beacon is mounted on one of some things. */
export function isMountedOn({ type, values }: Item, names: ReadonlySet<string | null>): boolean {
  return type === "Beacon" && typeof values["on"] === "string" && names.has(values["on"]);
}

/** Return a thing that refers to renamed things by their new names. */
export function withLinks(thing: Values, names: ReadonlyMap<string, string>): Values {
  const fresh = structuredClone(thing);
  for (const link of LINKS) {
    const named = linkAfter(at(thing, link), names);
    const inside = at(fresh, link.slice(0, -1)) as Values | undefined;
    if (named !== null && inside) inside[String(link.at(-1))] = named;
  }
  return fresh;
}

/** Return a reference after things were renamed; null if it does not change. */
function linkAfter(link: unknown, names: ReadonlyMap<string, string>): string | null {
  if (typeof link !== "string") return null;
  const [thing, target] = [link.slice(0, link.lastIndexOf(".")), link.slice(link.lastIndexOf("."))];
  const named = names.get(thing);
  return names.get(link) ?? (named === undefined ? null : named + target);
}

function at(value: unknown, [key, ...deeper]: Path): unknown {
  if (key === undefined) return value;
  return typeof value === "object" && value !== null ? at((value as Values)[key], deeper) : undefined;
}
