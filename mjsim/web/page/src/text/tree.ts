/** Ways through the tree of a text of YAML. */

import type { syntaxTree } from "@codemirror/language";
import type { Level } from "../panel/schema";

export type SyntaxNode = ReturnType<typeof syntaxTree>["topNode"];
/** Gives the text of a node. */
export type Read = (node: SyntaxNode) => string;

/** The keys that lead to one, the outermost first, each with those that stand beside it. */
export function levelsOf(key: SyntaxNode, read: Read): Level[] {
  const levels: Level[] = [];
  for (let pair = key.parent; pair; pair = ancestor(pair.parent, "Pair")) {
    const name = nameOf(pair, read);
    const beside = pair.parent?.getChildren("Pair").map((other) => nameOf(other, read)) ?? [];
    levels.unshift({ key: name, beside });
  }
  return levels;
}

export function nameOf(pair: SyntaxNode, read: Read): string {
  const key = pair.getChild("Key");
  return key ? plain(read(key)) : "";
}

/** The value of a pair, when it is a single word or text. */
export function textOf(pair: SyntaxNode, read: Read): string | null {
  const value = pair.getChild("Literal") ?? pair.getChild("QuotedLiteral");
  return value ? plain(read(value)) : null;
}

/** The value of a key that stands beside a pair, or in one of the mappings around it. */
export function beside(pair: SyntaxNode, key: string, read: Read): string | null {
  const found = pair.parent?.getChildren("Pair").find((other) => nameOf(other, read) === key);
  return found ? textOf(found, read) : null;
}

export function ancestor(node: SyntaxNode | null, name: string): SyntaxNode | null {
  for (let now = node; now; now = now.parent) if (now.name === name) return now;
  return null;
}

/** A text without the quotes around it. */
export function plain(text: string): string {
  return text.replace(/^["']|["']$/g, "");
}
