/** The list of undo steps: what each did, the newest first; pressing one goes to the text after it. */

import { sign } from "../ui/icons";
import { openMenu } from "../ui/menu";
import { html, type View } from "../ui/view";
import { word } from "../words/words";
import type { WorldDocument } from "./document";

export function stepsButton(world: WorldDocument): View {
  const title = word("shell.undoSteps");
  return html`<button class="quiet square" title=${title} aria-label=${title} aria-haspopup="menu"
    ?disabled=${!world.canUndo && !world.canRedo} @click=${(event: Event) => open(world, event.currentTarget as Element)}
    >${sign("steps")}</button>`;
}

function open(world: WorldDocument, button: Element): void {
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
