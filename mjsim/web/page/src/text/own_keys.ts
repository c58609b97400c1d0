/** The keys that a module has for itself, beside its `use`. */

import type { Module } from "../api";
import { allOf } from "../panel/offers";
import type { Field, SchemaBook } from "../panel/schema";
import type { Studio } from "../shell/view";

/** Modules that come with mjsim, and those beside the world. */
export async function modulesOf(studio: Studio): Promise<Module[]> {
  const { path, needsName } = studio.document;
  return allOf(await studio.api.modules(needsName ? null : path));
}

/** The keys of a module as fields; none of what is not known. */
export async function ownKeys(studio: Studio, book: SchemaBook, use: string | null): Promise<Field[]> {
  const module = use === null ? undefined : (await modulesOf(studio)).find((one) => one.use === use);
  return module ? book.fields(module.options) : [];
}
