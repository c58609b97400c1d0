/** All keys of the studio on one sheet. */

import { askWith } from "../ui/dialog";
import { el } from "../ui/dom";
import { word } from "../words/words";

const KEYS: [string, string][] = [
  ["Alt 1 / 2 / 3", word("shell.editRunReview")],
  ["Ctrl S, Ctrl Shift S", word("shell.saveSaveUnderAnother")],
  ["Ctrl O", word("shell.keyOpen")],
  ["Ctrl Z, Ctrl Shift Z", word("shell.undoRedoBackTo")],
  ["V  H", word("shell.selectMoveThePaper")],
  ["W  D  N", word("shell.drawAWallPut")],
  ["B  C  P  R  M", word("shell.putInABox")],
  ["Enter, Esc", word("shell.endTheWallGive")],
  ["Page Down, Page Up", word("shell.nextPreviousThingOn")],
  [word("shell.keyArrows"), word("shell.moveWhatIsSelected")],
  ["[  ]", word("shell.turnByWithShift")],
  ["Ctrl D, Delete", word("shell.duplicateDelete")],
  ["Ctrl C, Ctrl X, Ctrl V, Ctrl A", word("shell.copyCutPasteSelect")],
  ["Ctrl G, Ctrl Shift G", word("shell.groupUngroup")],
  ["F2", word("shell.rename")],
  [word("shell.keyMenu"), word("shell.menuOfWhatIs")],
  ["+  −  0", word("shell.zoomInZoomOut")],
  [word("shell.keyDragging"), word("shell.doNotSnap")],
  ["F6", word("shell.fromTheToolsTo")],
  [word("shell.keyInText"), word("shell.theNextProblem")],
  ["Y", word("shell.showOrHideThe")],
  [word("shell.keySpace"), word("shell.runStartPauseGo")],
  ["W A S D, Q E", word("shell.runDriveTheRobot")],
  [".  ,", word("shell.aTickOnIn")],
  ["F", word("shell.followTheRobot")],
  ["T", word("shell.touchTheRun")],
  [word("shell.keyOnAPanel"), word("shell.panelToASide")],
  ["←  →, Home, End", word("shell.reviewASecondBack")],
  ["I  O, Esc", word("shell.reviewThePartBegins")],
];

/** Show them; a button above them takes the tour, where there is one. */
export async function askHelp(tour?: () => void): Promise<void> {
  const wanted = await askWith<"tour">(word("shell.keys"), (answer) => [
    tour ? el("button", { class: "take-tour", onclick: () => answer("tour") }, word("shell.takeTheTour")) : null,
    el("div", { class: "keys" }, ...KEYS.flatMap(([keys, what]) => [el("kbd", {}, keys), el("span", {}, what)])),
  ]);
  if (wanted) tour?.();
}
