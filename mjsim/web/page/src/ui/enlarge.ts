/** A button by which a figure fills the window, until it is pressed again, or Escape. */

import { word } from "../words/words";
import { isPressed, toggle } from "./controls";
import { icon } from "./icons";

export function enlarger(figure: HTMLElement): HTMLButtonElement {
  const press = toggle(
    { class: "quiet square enlarger", title: word("ui.fillTheWindow") },
    false,
    (on) => figure.classList.toggle("enlarged", on),
    icon("enlarge"),
  );
  figure.addEventListener("keydown", (event) => {
    if (event.key !== "Escape" || !isPressed(press)) return;
    press.click();
    event.stopPropagation();
  });
  return press;
}
