/** From a word of the text to where it is defined: a thing by its name, another file of the world, a module. */

import type { EditorState, Extension } from "@codemirror/state";
import { EditorView, keymap } from "@codemirror/view";
import { syntaxTree } from "@codemirror/language";
import type { Studio } from "../shell/view";
import { showSource } from "./source";

/** A value of the text that stands for something elsewhere. */
const SPEC = /^[\w./-]+(\.py)?:[A-Za-z_]\w*$/;

/** Ctrl and a click, Command and a click, or F12 lead to what a name, an include or a `use:` stands for. */
export function definitions(studio: Studio, goTo: (line: number) => void): Extension {
  const follow = (state: EditorState, at: number): boolean => {
    const word = valueAt(state, at);
    if (!word) return false;
    const item = studio.document.items.find(({ name, line }) => name === word && line !== state.doc.lineAt(at).number);
    if (item && item.origin !== "include") goTo(item.line);
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

/** The value that a place of the text lies in, without quotes. */
function valueAt(state: EditorState, at: number): string | null {
  for (const side of [1, -1] as const) {
    const node = syntaxTree(state).resolveInner(at, side);
    if (["Literal", "QuotedLiteral"].includes(node.name) && node.parent?.name !== "Key")
      return state.sliceDoc(node.from, node.to).replace(/^["']|["']$/g, "");
  }
  return null;
}
