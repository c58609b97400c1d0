/** From a word of the text to where it is defined: a thing or a part by its name, another file of the world, a module. */

import { syntaxTree } from "@codemirror/language";
import type { EditorState, Extension } from "@codemirror/state";
import { EditorView, keymap } from "@codemirror/view";
import { beside as placedBeside } from "../shell/paths";
import type { Studio } from "../shell/view";
import { meant, namesIn } from "./names";
import { showSource, showText } from "./source";
import { ancestor, nameOf, plain, type Read, type SyntaxNode } from "./tree";

/** A value of the text that stands for something elsewhere. */
const SPEC = /^[\w./-]+(\.py)?:[A-Za-z_]\w*$/;
/** Keys under which each key is the name of a thing, a part or a joint. */
const NAMED_BY_KEYS = ["drivers", "controllers", "around", "about_deg", "gain", "joints_deg"];

/** Ctrl and a click, Command and a click, or F12 lead to what a name, an include or a `use:` stands for. */
export function definitions(studio: Studio, goTo: (line: number) => void): Extension {
  const follow = (state: EditorState, at: number): boolean => {
    const node = nodeAt(state, at);
    if (!node) return false;
    const read: Read = (one) => state.sliceDoc(one.from, one.to);
    const word = plain(read(node));
    const tree = syntaxTree(state);
    const name = meant(word, node, namesIn(tree, read), read);
    if (name) return (goTo(state.doc.lineAt(name.from).number), true);
    // A repetition, or what has no name of its own in the text.
    const item = studio.document.items.find((one) => one.name === word);
    if (item && item.origin !== "include") return item.line !== state.doc.lineAt(at).number && (goTo(item.line), true);
    const pair = ancestor(node, "Pair");
    if (pair && nameOf(pair, read) === "include") void showFile(studio, word);
    else if (item) void showIncluded(studio, word);
    else if (SPEC.test(word)) void showSource(studio, word);
    else return false;
    return true;
  };
  return [
    keymap.of([{ key: "F12", run: ({ state }) => follow(state, state.selection.main.head) }]),
    EditorView.domEventHandlers({
      mousedown: (event, view) => {
        if (event.button !== 0 || !(event.ctrlKey || event.metaKey)) return false;
        const at = view.posAtCoords({ x: event.clientX, y: event.clientY });
        return at !== null && follow(view.state, at) && (event.preventDefault(), true);
      },
    }),
  ];
}

/** Show an included file as it is on disk. */
async function showFile(studio: Studio, include: string): Promise<void> {
  try {
    const { text } = await studio.api.open(placedBeside(studio.document.path, include));
    await showText(include, text, 1);
  } catch (error) {
    studio.toasts.error(error);
  }
}

/** Show the included file that has a thing of a name, where that stands. */
async function showIncluded(studio: Studio, name: string): Promise<void> {
  const files = Object.keys(studio.document.parsed.files).filter((file) => /\.ya?ml$/.test(file));
  for (const file of files) {
    const opened = await studio.api.open(placedBeside(studio.document.path, file)).catch(() => null);
    const item = opened?.items?.find((one) => one.name === name && one.origin !== "include");
    if (opened && item) return showText(file, opened.text, item.line);
  }
}

/** The value that a place of the text lies in, or the key, where keys are names. */
function nodeAt(state: EditorState, at: number): SyntaxNode | null {
  for (const side of [1, -1] as const) {
    const node = syntaxTree(state).resolveInner(at, side);
    if (!["Literal", "QuotedLiteral"].includes(node.name)) continue;
    if (node.parent?.name !== "Key") return node;
    const around = ancestor(node.parent.parent?.parent ?? null, "Pair");
    const read: Read = (one) => state.sliceDoc(one.from, one.to);
    if (around && NAMED_BY_KEYS.includes(nameOf(around, read))) return node;
  }
  return null;
}
