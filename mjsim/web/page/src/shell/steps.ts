/** The list of undo steps: what each did, the newest first; pressing one goes to the text after it. */

import { el } from "../ui/dom";
import { icon } from "../ui/icons";
import { openMenu } from "../ui/menu";
import { word } from "../words/words";
import type { WorldDocument } from "./document";

export function stepsButton(world: WorldDocument): HTMLButtonElement {
  const title = word("shell.undoSteps");
  const attributes = { class: "quiet square", title, "aria-label": title, "aria-haspopup": "menu" };
  const button = el("button", { ...attributes, onclick: () => open(world, button) }, icon("steps"));
  return button;
}

function open(world: WorldDocument, button: HTMLElement): void {
  const { names, at } = world.steps;
  const entries = [word("shell.opened"), ...names].map((text, step) => ({
    text,
    checked: step === at,
    faint: step > at,
    act: () => void world.goTo(step),
  }));
  const { left, bottom } = button.getBoundingClientRect();
  openMenu(word("shell.undoSteps"), [entries.reverse()], [left, bottom + 4]);
}
