/** What can be done with what is selected, in a menu where it was asked for. */

import type { Item } from "../api";
import { type Entry, openMenu } from "../ui/menu";
import { word } from "../words/words";
import type { Editor } from "./editor";
import { groupable, groupOf, wholeGroup, withGroups } from "./groups";
import { canTurn } from "./shapes";

/** Ways from a thing to other places of the Edit view. */
export interface Ways {
  /** Go to its line of the text. */
  text(item: Item): void;
  /** Show it in 3-D. */
  solid(): void;
  rename(item: Item): void;
  canRename(item: Item): boolean;
}

/** Open the menu of what is selected; of the free paper when nothing is. */
export function openContextMenu(editor: Editor, ways: Ways, at: [number, number]): void {
  const { selected } = editor;
  const [first] = selected;
  const name =
    selected.length === 1 && first
      ? first.label
      : selected.length
        ? word("edit.things2", { count: selected.length })
        : word("edit.plan");
  openMenu(name, first ? ofThings(editor, ways, selected, first) : ofPaper(editor), at);
}

function ofPaper(editor: Editor): Entry[][] {
  return [
    [
      paste(editor),
      { text: word("edit.selectAll"), keys: "Ctrl A", act: () => editor.selectAll() },
      { text: word("edit.showAll"), keys: "0", act: () => editor.plan.fit() },
    ],
  ];
}

function ofThings(editor: Editor, ways: Ways, selected: Item[], first: Item): Entry[][] {
  const free = selected.every((item) => !item.fixed);
  const copies = selected.some((item) => item.type !== "Opening");
  const turns = free && selected.some(canTurn);
  const alone = selected.length === 1;
  const foreign = selected.some((item) => item.origin);
  const repeated = selected.some((item) => item.origin === "repeat");
  const offered: [boolean, Entry][][] = [
    [
      [free && copies, { text: word("edit.cut"), keys: "Ctrl X", act: () => document.execCommand("cut") }],
      [copies, { text: word("edit.copy"), keys: "Ctrl C", act: () => document.execCommand("copy") }],
      [true, paste(editor)],
      [copies, { text: word("edit.duplicate"), keys: "Ctrl D", act: () => editor.duplicate() }],
      [free, { text: word("edit.delete"), keys: word("edit.del"), act: () => void editor.remove() }],
    ],
    [
      [alone && ways.canRename(first), { text: word("edit.rename"), keys: "F2", act: () => ways.rename(first) }],
      [foreign, { text: word("edit.makeSingle"), act: () => editor.makeSingle() }],
      [repeated, { text: word("edit.makeAllSingle"), act: () => editor.makeSingle("single") }],
      [
        groupable(selected).length > 1 && !wholeGroup(selected, editor.items),
        { text: word("edit.group"), keys: "Ctrl G", act: () => void editor.group(true) },
      ],
      [
        groupable(selected).some(groupOf),
        { text: word("edit.ungroup"), keys: "Ctrl Shift G", act: () => void editor.group(false) },
      ],
      [
        withGroups(selected, editor.items).length > selected.length,
        { text: word("edit.selectGroup"), act: () => editor.pick(selected) },
      ],
      [turns, { text: word("edit.turnLeft"), act: () => editor.turn(90) }],
      [turns, { text: word("edit.turnRight"), act: () => editor.turn(-90) }],
    ],
    [
      [
        alone && first.origin !== "include",
        { text: word("edit.goToLineOfThe", { line: first.line }), act: () => ways.text(first) },
      ],
      [true, { text: word("edit.showInD"), act: () => ways.solid() }],
    ],
  ];
  return offered.map((group) => group.flatMap(([applies, entry]) => (applies ? [entry] : [])));
}

/** What is on the clipboard; what was copied on this page where the browser does not let it be read. */
function paste(editor: Editor): Entry {
  const read = async (): Promise<string | undefined> => navigator.clipboard?.readText().catch(() => undefined);
  return { text: word("edit.paste"), keys: "Ctrl V", act: () => void read().then((text) => editor.paste(text)) };
}
