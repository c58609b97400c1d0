/** All keys of the studio on one sheet. */

import { el } from "../dom";
import { askWith } from "./dialog";

const KEYS: [string, string][] = [
  ["Alt 1 / 2 / 3", "Edit, Run, Review"],
  ["Ctrl S, Ctrl Shift S", "save, save under another name"],
  ["Ctrl O", "open a world"],
  ["Ctrl Z, Ctrl Shift Z", "undo, redo: back to the first letter"],
  ["V  H", "select, move the paper (or hold Space)"],
  ["W  D  N", "draw a wall, put in a doorway, a window"],
  ["B  C  P  R  M", "put in a box, a cylinder, a picture, a robot, one of all other things"],
  ["Enter, Esc", "end the wall, give it up"],
  ["Page Down, Page Up", "next, previous thing on the plan"],
  ["Arrows", "move what is selected by a step of the grid; with Shift by 1 cm, with Ctrl by 1 m; else the paper or the cross of a tool"],
  ["[  ]", "turn by 15°; with Shift by 1°"],
  ["Ctrl D, Delete", "duplicate, delete"],
  ["Ctrl C, Ctrl X, Ctrl V, Ctrl A", "copy, cut, paste, select all"],
  ["F2", "rename"],
  ["Shift F10, right click", "menu of what is selected"],
  ["+  −  0", "zoom in, zoom out, show all"],
  ["Alt while dragging", "do not snap"],
  ["F6", "from the tools to the plan, the text, the fields"],
  ["F8 in the text", "the next problem"],
  ["T", "show or hide the text"],
  ["Space", "Run: start, pause, go on; Review: play, pause"],
  ["W A S D, Q E", "Run: drive the robot, and sideways"],
  [".  ,", "a tick on; in Review also back"],
  ["F", "follow the robot"],
  ["←  →, Home, End", "Review: a second back or on, begin, end"],
  ["I  O, Esc", "Review: the part begins, ends; mark nothing"],
];

/** Show them; a button above them takes the tour, where there is one. */
export async function askHelp(tour?: () => void): Promise<void> {
  const wanted = await askWith<"tour">("Keys", (answer) => [
    tour ? el("button", { class: "take-tour", onclick: () => answer("tour") }, "Take the tour") : null,
    el("div", { class: "keys" }, ...KEYS.flatMap(([keys, what]) => [el("kbd", {}, keys), el("span", {}, what)])),
  ]);
  if (wanted) tour?.();
}
