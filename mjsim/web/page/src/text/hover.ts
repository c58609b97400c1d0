/** What a key of the world means, with its unit, its default and its values, where the pointer rests on it in the text. */

import { syntaxTree } from "@codemirror/language";
import type { Extension } from "@codemirror/state";
import { hoverTooltip } from "@codemirror/view";
import { el } from "../dom";
import type { Field, Level, SchemaBook } from "../panel/schema";
import { word } from "../words/words";

type SyntaxNode = ReturnType<typeof syntaxTree>["topNode"];

/** Told of the keys of a text by what the schema says of them. */
export function hoverHints(book: SchemaBook): Extension {
  return hoverTooltip((view, at, side) => {
    const node = syntaxTree(view.state).resolveInner(at, side);
    const key = ancestor(node, "Key");
    const field = key && book.along(levelsOf(key, (each) => view.state.sliceDoc(each.from, each.to)));
    if (!key || !field) return null;
    return { pos: key.from, end: key.to, above: true, create: () => ({ dom: hint(field) }) };
  });
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
  return el("div", { class: "cm-hint" }, head, meaning ? el("p", {}, meaning) : null, said ? el("p", { class: "hint" }, said) : null);
}

/** The keys that lead to one, the outermost first, each with those that stand beside it. */
export function levelsOf(key: SyntaxNode, read: (node: SyntaxNode) => string): Level[] {
  const levels: Level[] = [];
  for (let pair = key.parent; pair; pair = ancestor(pair.parent, "Pair")) {
    const name = nameOf(pair, read);
    const beside = pair.parent?.getChildren("Pair").map((other) => nameOf(other, read)) ?? [];
    levels.unshift({ key: name, beside });
  }
  return levels;
}

function nameOf(pair: SyntaxNode, read: (node: SyntaxNode) => string): string {
  const key = pair.getChild("Key");
  return key ? read(key).replace(/^["']|["']$/g, "") : "";
}

export function ancestor(node: SyntaxNode | null, name: string): SyntaxNode | null {
  for (let now = node; now; now = now.parent) if (now.name === name) return now;
  return null;
}
