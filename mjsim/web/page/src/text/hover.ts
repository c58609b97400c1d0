/** What a key of the world means, with its unit, its default and its values, where the pointer rests on it in the text. */

import { syntaxTree } from "@codemirror/language";
import type { Extension } from "@codemirror/state";
import { type EditorView, hoverTooltip, type Tooltip } from "@codemirror/view";
import type { Field, SchemaBook } from "../panel/schema";
import type { Studio } from "../shell/view";
import { el } from "../ui/dom";
import { word } from "../words/words";
import { ownKeys } from "./own_keys";
import { ancestor, beside, levelsOf, nameOf, type Read, type SyntaxNode } from "./tree";

/** Told of the keys of a text by what the schema says of them, and of those of a module by what the module does. */
export function hoverHints(book: SchemaBook, studio: Studio): Extension {
  const source = async (view: EditorView, at: number, side: -1 | 1): Promise<Tooltip | null> => {
    const key = ancestor(syntaxTree(view.state).resolveInner(at, side), "Key");
    if (!key) return null;
    const read: Read = (node) => view.state.sliceDoc(node.from, node.to);
    const field = book.along(levelsOf(key, read)) ?? (await ofModule(key, read, book, studio));
    return field && { pos: key.from, end: key.to, above: true, create: () => ({ dom: hint(field) }) };
  };
  return hoverTooltip(source);
}

async function ofModule(key: SyntaxNode, read: Read, book: SchemaBook, studio: Studio): Promise<Field | null> {
  const pair = ancestor(key, "Pair");
  const own = pair ? await ownKeys(studio, book, beside(pair, "use", read)).catch(() => []) : [];
  return own.find((field) => pair && field.key === nameOf(pair, read)) ?? null;
}

export function hint(field: Field): HTMLElement {
  const { key, unit, meaning, fallback, kind, required } = field;
  const facts = [
    required ? word("text.required") : "",
    fallback === undefined || fallback === null ? "" : word("text.default", { value: JSON.stringify(fallback) }),
    kind.is === "choice" ? word("text.oneOf", { options: kind.options.join(", ") }) : "",
  ];
  const said = facts.filter((fact) => fact && fact.length < 200).join("; ");
  const head = el("p", {}, el("b", {}, key), unit ? ` [${unit}]` : "");
  return el(
    "div",
    { class: "cm-hint" },
    head,
    meaning ? el("p", {}, meaning) : null,
    said ? el("p", { class: "hint" }, said) : null,
  );
}
