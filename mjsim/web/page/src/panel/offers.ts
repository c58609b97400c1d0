/** Which modules there are for a robot: those that fit its sensors, and what is written of one that is chosen. */

import type { Item, Module, Modules, Path, Values } from "../api";
import type { SchemaBook } from "./schema";

export type Role = "observer" | "estimator" | "navigator" | "avoidance" | "controller";

const ROLES: Role[] = ["observer", "estimator", "navigator", "avoidance", "controller"];

/** The role of a key of the world file. */
export function roleOf(key: string): Role {
  return ROLES.find((role) => role === key) ?? "controller";
}

export function offersFor(modules: Modules, role: Role): Module[] {
  return modules[`${role}s`];
}

export function allOf(modules: Modules): Module[] {
  return ROLES.flatMap((role) => offersFor(modules, role));
}

export function isShipped({ use }: Module): boolean {
  return use.startsWith("mjsim.");
}

export function fits({ needs, parts }: Module, given: Set<string>): boolean {
  return (needs.length === 0 || needs.some((reading) => given.has(reading))) && parts.every((part) => given.has(part));
}

/** What a robot has: parts that modules ask for, readings, with those of its observer or of one that its cameras allow. */
export function readingsOf(robot: Item | null, modules: Modules): Set<string> {
  const found = sensorsOf(robot).flatMap((sensor) => Object.keys(modules.sensors).filter((kind) => kind in sensor));
  const given = new Set(found.map((kind) => modules.sensors[kind] ?? ""));
  if (given.has("cameras")) given.add("sightings");
  if (listOf(robot?.values["arms"]).length) given.add("joints").add("arms");
  const drive = robot?.values["drive"] as Values | null | undefined;
  if (drive?.["type"] === "balancing") given.add("balancing");
  if (["mecanum", "omni3"].includes(String(drive?.["type"])) || Number(drive?.["max_left"] ?? 0) > 0)
    given.add("max_left");
  return given;
}

/** The names of a robot's parts that an option such as `camera` or `arm` may be. */
export function partsNamed(robot: Item | null, key: string): string[] {
  if (key === "arm") return listOf(robot?.values["arms"]).flatMap(({ name }) => (typeof name === "string" ? name : []));
  return sensorsOf(robot).flatMap((sensor) => (typeof sensor[key] === "string" ? sensor[key] : []));
}

/** The names of a robot's parts that a controller may drive. */
export function drivenParts(robot: Item | null): string[] {
  const balances = (robot?.values["drive"] as Values | null | undefined)?.["type"] === "balancing";
  return [...(balances ? ["drive"] : []), ...partsNamed(robot, "arm")];
}

/** What is written of a module that was chosen: its `use`, what it requires, and the parts that it is to take. */
export function begun(module: Module, robot: Item | null, book: SchemaBook): Values {
  const given = book.fields(module.options).flatMap(({ key, kind, required, fallback }): [string, unknown][] => {
    const parts = partsNamed(robot, key);
    const isMissing = typeof fallback === "string" && parts.length > 0 && !parts.includes(fallback);
    if (parts.length && (required || isMissing)) return [[key, parts[0]]];
    if (!required) return [];
    const properties = module.options["properties"] as Record<string, Values>;
    return [[key, kind.is === "list" ? [book.fresh(kind.entry)] : book.fresh(properties[key] ?? {}, key)]];
  });
  return { use: module.use, ...Object.fromEntries(given) };
}

/** Modules that fit a robot as they are, by role; in a world without beacons a lidar comes first. */
export function suggested(robot: Item, hasBeacons: boolean, modules: Modules, book: SchemaBook): Values {
  const given = readingsOf(robot, modules);
  if (!hasBeacons && given.has("scans")) for (const reading of ["sightings", "cameras"]) given.delete(reading);
  const chosen = (["observer", "estimator", "navigator"] as const).flatMap((role) => {
    const offer = offersFor(modules, role).find((one) => isShipped(one) && fits(one, given));
    return offer ? [[role, begun(offer, robot, book)]] : [];
  });
  return { ...(Object.fromEntries(chosen) as Values), avoidance: true };
}

/** The robot of a driver in the world file; null elsewhere. */
export function robotAt(path: Path, items: Item[]): Item | null {
  const [run, drivers, name] = path;
  if (run !== "run" || drivers !== "drivers") return null;
  return items.find((item) => item.type === "Robot" && item.name === name) ?? null;
}

function sensorsOf(robot: Item | null): Values[] {
  return listOf(robot?.values["sensors"]);
}

function listOf(value: unknown): Values[] {
  return Array.isArray(value) ? (value as Values[]) : [];
}
