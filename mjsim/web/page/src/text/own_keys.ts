/** The keys that a module has for itself, beside its `use`. */

import type { Module } from "../api";
import { type Field, labelOf } from "../panel/schema";
import type { Studio } from "../shell/view";

/** Modules that come with mjsim, and those beside the world. */
export async function modulesOf(studio: Studio): Promise<Module[]> {
  const { path, needsName } = studio.document;
  const all = await studio.api.modules(needsName ? null : path);
  return Object.values(all).flat();
}

/** The keys of a module as fields; none of what is not known. */
export async function ownKeys(studio: Studio, use: string | null): Promise<Field[]> {
  const module = use === null ? undefined : (await modulesOf(studio)).find((one) => one.use === use);
  return (module?.keys ?? []).map((key): Field => {
    const { name, about, default: fallback } = key;
    const common = { key: name, label: labelOf(name), unit: "", meaning: about, fallback, nullable: false };
    return { ...common, required: !("default" in key), kind: { is: "data" } };
  });
}
