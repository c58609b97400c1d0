/** On a small screen the fields or the text stand by the plan, one at a time, or neither; where there is room, both. */

import { setPressed, toggle } from "../ui/controls";
import { el } from "../ui/dom";
import { word } from "../words/words";

type Pane = "fields" | "text";

export class Panes {
  /** The buttons that open and shut them; styles show it on small screens alone. */
  readonly element = el("div", { class: "panes", role: "group", "aria-label": word("edit.besideThePlan") });
  private readonly buttons: Record<Pane, HTMLButtonElement>;

  constructor(
    private readonly view: HTMLElement,
    private readonly opened: () => void,
  ) {
    const make = (pane: Pane, text: string): HTMLButtonElement =>
      toggle({}, false, (on) => this.put(on ? pane : null), text);
    this.buttons = { fields: make("fields", word("edit.fields")), text: make("text", word("edit.text")) };
    this.element.append(this.buttons.fields, this.buttons.text);
  }

  /** Whether the screen is so small that they take turns. */
  get takeTurns(): boolean {
    return getComputedStyle(this.element).display !== "none";
  }

  open(pane: Pane): void {
    this.put(pane);
  }

  /** Open one, or shut it where it is open. */
  turn(pane: Pane): void {
    this.buttons[pane].click();
  }

  private put(open: Pane | null): void {
    this.view.dataset["pane"] = open ?? "";
    for (const [pane, button] of Object.entries(this.buttons)) setPressed(button, pane === open);
    this.opened();
  }
}
