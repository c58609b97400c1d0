/** Words of the text editor: what its library says in English is looked up here. */

import { EditorState, type Extension } from "@codemirror/state";
import { type Key, word } from "../words/words";

/** Phrases of CodeMirror; $ in them is replaced by it. */
const PHRASES: Record<string, Key> = {
  Completions: "text.completions",
  "Control character": "text.controlCharacter",
  Diagnostics: "text.diagnostics",
  Find: "text.find",
  "Fold line": "text.foldLine",
  "Go to line": "text.goToLine",
  "No diagnostics": "text.noDiagnostics",
  Replace: "text.replaceBy",
  "Selection deleted": "text.selectionDeleted",
  "Unfold line": "text.unfoldLine",
  all: "text.all",
  "by word": "text.byWord",
  close: "text.close",
  "current match": "text.currentMatch",
  "folded code": "text.foldedCode",
  go: "text.go",
  "match case": "text.matchCase",
  next: "text.next",
  "on line": "text.onLine",
  previous: "text.previous",
  regexp: "text.regexp",
  replace: "text.replace",
  "replace all": "text.replaceAll",
  "replaced $ matches": "text.replacedMatches",
  "replaced match on line $": "text.replacedMatchOnLine",
  unfold: "text.unfold",
};

export function phrases(): Extension {
  return EditorState.phrases.of(
    Object.fromEntries(Object.entries(PHRASES).map(([phrase, key]) => [phrase, word(key)])),
  );
}
