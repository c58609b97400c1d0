/** Colours of the text: those of the theme, so that light and dark need no second set. */

import { HighlightStyle, syntaxHighlighting } from "@codemirror/language";
import { EditorView } from "@codemirror/view";
import { tags } from "@lezer/highlight";

export const HIGHLIGHT = syntaxHighlighting(
  HighlightStyle.define([
    { tag: [tags.definition(tags.propertyName), tags.propertyName], color: "var(--code-key)" },
    { tag: [tags.string, tags.special(tags.string)], color: "var(--code-text)" },
    { tag: [tags.number, tags.bool, tags.null, tags.keyword], color: "var(--code-number)" },
    { tag: tags.comment, color: "var(--code-note)", fontStyle: "italic" },
    { tag: [tags.punctuation, tags.separator, tags.squareBracket, tags.brace], color: "var(--muted)" },
    { tag: [tags.meta, tags.labelName, tags.typeName], color: "var(--code-number)" },
  ]),
);

export const THEME = EditorView.theme({
  "&": { height: "100%", color: "var(--ink)", backgroundColor: "var(--paper)", fontSize: "12.5px" },
  "&.cm-focused": { outline: "none" },
  ".cm-scroller": { fontFamily: "var(--mono)", lineHeight: "1.55" },
  ".cm-content": { caretColor: "var(--ink)", padding: "6px 0" },
  ".cm-cursor": { borderLeftColor: "var(--ink)", borderLeftWidth: "2px" },
  ".cm-gutters": { backgroundColor: "var(--paper)", color: "var(--muted)", border: "none" },
  ".cm-activeLine": { backgroundColor: "color-mix(in srgb, var(--hover) 55%, transparent)" },
  ".cm-activeLineGutter": { backgroundColor: "transparent", color: "var(--ink)" },
  ".cm-chosen": { backgroundColor: "var(--accent-soft)", boxShadow: "inset 3px 0 var(--accent)" },
  "&.cm-focused > .cm-scroller > .cm-selectionLayer .cm-selectionBackground, .cm-selectionBackground": {
    background: "color-mix(in srgb, var(--accent) 28%, transparent)",
  },
  ".cm-foldPlaceholder": { background: "var(--hover)", border: "none", color: "var(--muted)" },
  ".cm-tooltip": {
    background: "var(--paper)",
    border: "1px solid var(--hair)",
    borderRadius: "6px",
    boxShadow: "var(--shadow)",
    maxWidth: "520px",
  },
  ".cm-tooltip.cm-tooltip-autocomplete > ul": { fontFamily: "var(--mono)", maxHeight: "16em" },
  ".cm-tooltip.cm-tooltip-autocomplete > ul > li": { padding: "2px 8px", color: "var(--ink)" },
  ".cm-tooltip.cm-tooltip-autocomplete > ul > li[aria-selected]": {
    background: "var(--accent-soft)",
    color: "var(--ink)",
  },
  ".cm-completionDetail": { color: "var(--muted)", fontStyle: "normal" },
  ".cm-completionMatchedText": { textDecoration: "none", fontWeight: "600" },
  ".cm-hint": { padding: "6px 10px", font: "13px/1.4 var(--font)" },
  ".cm-hint p": { margin: "0" },
  ".cm-diagnostic": { padding: "6px 10px", font: "13px/1.4 var(--font)", whiteSpace: "pre-wrap" },
  ".cm-diagnostic-error": { borderLeft: "3px solid var(--error)" },
  ".cm-diagnostic-warning": { borderLeft: "3px solid var(--warning)" },
  ".cm-lintRange-error": {
    backgroundImage: "none",
    textDecoration: "underline wavy var(--error) 1px",
    textUnderlineOffset: "3px",
  },
  ".cm-lintRange-warning": {
    backgroundImage: "none",
    textDecoration: "underline wavy var(--warning) 1px",
    textUnderlineOffset: "3px",
  },
  ".cm-lint-marker-error, .cm-lint-marker-warning": {
    content: "''",
    width: "8px",
    height: "8px",
    borderRadius: "50%",
    margin: "5px auto 0",
  },
  ".cm-lint-marker-error": { background: "var(--error)" },
  ".cm-lint-marker-warning": { background: "var(--warning)" },
  ".cm-gutter-lint": { width: "12px" },
  ".cm-panels": { background: "var(--raised)", color: "var(--ink)", borderColor: "var(--hair)" },
  ".cm-panel.cm-search": { display: "flex", flexWrap: "wrap", gap: "6px", alignItems: "center", padding: "6px 10px" },
  ".cm-panel.cm-search br": { display: "none" },
  ".cm-panel.cm-search input": { width: "auto" },
  ".cm-panel.cm-search button": { backgroundImage: "none", minHeight: "28px" },
  ".cm-selectionMatch": { backgroundColor: "color-mix(in srgb, var(--beacon) 25%, transparent)" },
  "&.cm-focused .cm-matchingBracket": { background: "var(--accent-soft)" },
});
