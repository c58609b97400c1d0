/** The YAML text beside the plan, live both ways: typing is read, the cursor selects, problems are marked. */

import { defaultKeymap, indentLess, indentMore } from "@codemirror/commands";
import { yaml } from "@codemirror/lang-yaml";
import { bracketMatching, foldGutter, foldKeymap, indentOnInput, indentUnit } from "@codemirror/language";
import { type Diagnostic, lintGutter, nextDiagnostic, setDiagnostics } from "@codemirror/lint";
import { highlightSelectionMatches, search, searchKeymap } from "@codemirror/search";
import {
  Annotation,
  Compartment,
  EditorState,
  type Extension,
  RangeSetBuilder,
  StateEffect,
  StateField,
} from "@codemirror/state";
import {
  Decoration,
  type DecorationSet,
  drawSelection,
  EditorView,
  highlightActiveLine,
  highlightActiveLineGutter,
  keymap,
  lineNumbers,
} from "@codemirror/view";
import type { Item, Problem } from "../api";
import { withoutList } from "../edit/clipboard";
import type { SchemaBook } from "../panel/schema";
import type { WorldDocument } from "../shell/document";
import type { Studio } from "../shell/view";
import { said, word } from "../words/words";
import { completion } from "./completion";
import { definitions } from "./definition";
import { difference } from "./difference";
import { hoverHints } from "./hover";
import { HIGHLIGHT, THEME } from "./look";
import { phrases } from "./phrases";

/** A change that came from elsewhere, not from the keyboard. */
const fromOutside = Annotation.define<boolean>();
const markLines = StateEffect.define<[number, number][]>();
const marked = Decoration.line({ class: "cm-chosen" });

const chosenLines = StateField.define<DecorationSet>({
  create: () => Decoration.none,
  update(lines, transaction) {
    for (const effect of transaction.effects)
      if (effect.is(markLines)) return decorate(transaction.state, effect.value);
    return lines.map(transaction.changes);
  },
  provide: (field) => EditorView.decorations.from(field),
});

export class TextPane {
  readonly element: HTMLElement;
  readonly view: EditorView;
  private readonly endings = new Compartment();
  private typed = false;

  constructor(
    private readonly world: WorldDocument,
    private readonly book: SchemaBook,
    private readonly studio: Studio,
  ) {
    this.view = new EditorView({ doc: "", extensions: this.extensions() });
    this.element = this.view.dom;
    world.textChanged.on((origin) => origin !== "type" && this.take(origin === "open"));
    world.parsedChanged.on(() => {
      this.showProblems(world.parsed.problems);
      // What is being written is what is shown, unless somebody went on to something else meanwhile.
      if (this.typed && this.view.hasFocus) this.followCursor();
      this.typed = false;
      this.showSelection(false);
    });
    world.selectionChanged.on(() => this.showSelection(!this.view.hasFocus));
    this.take(true);
  }

  /** Go to a line, counted from 1, and stand there. */
  goTo(line: number, column = 1): void {
    const { doc } = this.view.state;
    const at = doc.line(Math.min(Math.max(line, 1), doc.lines));
    const position = at.from + offsetOf(at.text, column);
    this.view.dispatch({
      selection: { anchor: position },
      effects: EditorView.scrollIntoView(position, { y: "center" }),
    });
    this.view.focus();
  }

  private extensions(): Extension[] {
    return [
      lineNumbers(),
      lintGutter(),
      foldGutter(),
      drawSelection(),
      highlightActiveLine(),
      highlightActiveLineGutter(),
      indentOnInput(),
      bracketMatching(),
      highlightSelectionMatches(),
      search({ top: true }),
      hoverHints(this.book, this.studio),
      completion(this.book, this.studio),
      definitions(this.studio, (line) => this.goTo(line)),
      EditorView.clipboardInputFilter.of((text, state) => {
        const above = state.doc.slice(0, state.selection.main.from).toString().split("\n");
        return withoutList(text, above);
      }),
      indentUnit.of("  "),
      yaml(),
      HIGHLIGHT,
      THEME,
      phrases(),
      chosenLines,
      this.endings.of(EditorState.lineSeparator.of("\n")),
      EditorView.contentAttributes.of({ "aria-label": word("text.textOfTheWorldYaml"), tabindex: "0" }),
      // Tab indents lines that are selected; else it goes on through the page, as everywhere.
      keymap.of([
        {
          key: "Tab",
          run: (view) => !view.state.selection.main.empty && indentMore(view),
          shift: (view) => !view.state.selection.main.empty && indentLess(view),
        },
        { key: "Mod-]", run: indentMore },
        { key: "Mod-[", run: indentLess },
        { key: "F8", run: nextDiagnostic },
        { key: "Escape", run: (view) => (view.contentDOM.blur(), false) },
        ...defaultKeymap,
        ...foldKeymap,
        ...searchKeymap,
      ]),
      EditorView.updateListener.of((update) => {
        const outside = update.transactions.some((transaction) => transaction.annotation(fromOutside));
        if (outside) return;
        this.typed ||= update.docChanged;
        if (update.docChanged) this.world.type(update.state.sliceDoc());
        else if (update.selectionSet && update.view.hasFocus) this.followCursor();
      }),
    ];
  }

  /** Take the text over as it is now: only what differs, so that cursor and scrolling stay. */
  private take(anew: boolean): void {
    const text = this.world.shown;
    const separator = /\r\n/.test(text) && !/(^|[^\r])\n/.test(text) ? "\r\n" : "\n";
    // A file that was read again may have other ends of lines; a text of one line has none.
    if (anew || (separator !== this.view.state.lineBreak && text.includes("\n"))) {
      this.view.dispatch({
        effects: this.endings.reconfigure(EditorState.lineSeparator.of(separator)),
        annotations: fromOutside.of(true),
      });
    }
    const before = this.view.state.sliceDoc();
    if (before === text) return;
    const lineBreak = this.view.state.lineBreak;
    const [old, fresh] =
      lineBreak === "\n" ? [before, text] : [before.replaceAll(lineBreak, "\n"), text.replaceAll(lineBreak, "\n")];
    const { from, to, insert } = difference(old, fresh);
    const lines = this.view.state.toText(lineBreak === "\n" ? insert : insert.replaceAll("\n", lineBreak));
    this.view.dispatch({
      changes: { from, to, insert: lines },
      annotations: fromOutside.of(true),
      ...(anew ? { selection: { anchor: 0 }, scrollIntoView: true } : {}),
    });
  }

  private showProblems(problems: Problem[]): void {
    const { doc } = this.view.state;
    const found = problems.map((problem): Diagnostic => {
      const line = doc.line(Math.min(Math.max(problem.line, 1), doc.lines));
      const from = line.from + offsetOf(line.text, problem.column);
      const word = /^("[^"]*"|'[^']*'|[\w.$-]+|.)/.exec(doc.sliceString(from, line.to));
      return {
        from,
        to: Math.min(from + (word?.[0].length ?? 0), line.to),
        severity: problem.kind,
        message: said(problem.message),
      };
    });
    this.view.dispatch(setDiagnostics(this.view.state, found));
  }

  /** Mark the lines of what is selected on the plan, and bring the first into view. */
  private showSelection(scroll: boolean): void {
    const own = this.world.selectedItems.filter((item) => item.origin !== "include");
    const lines = own.length ? this.world.shown.split("\n") : [];
    const ranges = own.map((item): [number, number] => [item.line, lastLine(item, lines)]);
    const effects: StateEffect<unknown>[] = [markLines.of(ranges)];
    const [first] = ranges;
    const { doc } = this.view.state;
    if (first && scroll && first[0] <= doc.lines)
      effects.push(EditorView.scrollIntoView(doc.line(first[0]).from, { y: "nearest", yMargin: 60 }));
    this.view.dispatch({ effects });
  }

  private followCursor(): void {
    const { state } = this.view;
    const line = state.doc.lineAt(state.selection.main.head).number;
    const item = itemAtLine(line, this.world.items, this.world.text);
    this.world.select(item ? [item.path] : []);
  }
}

/** Return the offset of a column, counted from 1: the server counts code points, the editor units of UTF-16. */
function offsetOf(line: string, column: number): number {
  return [...line].slice(0, Math.max(column, 1) - 1).join("").length;
}

/** The innermost item whose text a line belongs to. */
export function itemAtLine(line: number, items: Item[], text: string): Item | null {
  const lines = text.split("\n");
  const before = items.filter((item) => !item.fixed && item.line <= line && lastLine(item, lines) >= line);
  return before.sort((a, b) => b.line - a.line || b.path.length - a.path.length)[0] ?? null;
}

/** Where an item's text ends: as far as lines are further in than its first key, comments and blank lines left out. */
function lastLine(item: Item, lines: string[]): number {
  const first = lines[item.line - 1] ?? "";
  const indent = first.search(/\S/) + (/^\s*-\s/.test(first) ? 1 : 0);
  let last = item.line;
  for (let number = item.line + 1; number <= lines.length; number++) {
    const line = lines[number - 1] ?? "";
    const inward = line.search(/\S/);
    if (inward < 0 || line[inward] === "#") continue;
    if (inward < Math.max(indent, 1)) break;
    last = number;
  }
  return last;
}

function decorate(state: EditorState, ranges: [number, number][]): DecorationSet {
  const builder = new RangeSetBuilder<Decoration>();
  const lines = new Set(
    ranges.flatMap(([from, to]) => Array.from({ length: to - from + 1 }, (_, index) => from + index)),
  );
  for (const number of [...lines].sort((a, b) => a - b)) {
    if (number < 1 || number > state.doc.lines) continue;
    const { from } = state.doc.line(number);
    builder.add(from, from, marked);
  }
  return builder.finish();
}
