/** Whether the column with setup, noise and events is shown: as it was left, else where there is room for it. */

import { remembered, setPressed, toggle } from "../ui/controls";
import { icon } from "../ui/icons";
import { word } from "../words/words";

/** A button that shows and hides the column. */
export function sideSwitch(side: HTMLElement): HTMLButtonElement {
  const narrow = window.matchMedia("(max-width: 1100px)");
  const put = (open: boolean): void => {
    side.hidden = !open;
    setPressed(button, open);
  };
  const button = toggle(
    { class: "quiet square", title: word("run.setupNoiseAndEvents") },
    true,
    (open) => {
      put(open);
      remembered("run.side", open ? "yes" : "no");
    },
    icon("side"),
  );
  const asLeft = (): void => put(remembered("run.side") === null ? !narrow.matches : remembered("run.side") === "yes");
  narrow.addEventListener("change", asLeft);
  asLeft();
  return button;
}
