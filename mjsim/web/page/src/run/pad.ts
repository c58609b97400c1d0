/** Arrows on the screen for those who drive with a finger. */

import { el } from "../ui/dom";
import { type IconName, icon } from "../ui/icons";
import { word } from "../words/words";
import type { Wheel } from "./keys";

const WAYS: [IconName, string, [number, number, number]][] = [
  ["turnLeft", word("run.turnLeftA"), [0, 0, 1]],
  ["up", word("run.forwardW"), [1, 0, 0]],
  ["turnRight", word("run.turnRightD"), [0, 0, -1]],
  ["arrowLeft", word("run.leftQ"), [0, 1, 0]],
  ["down", word("run.backS"), [-1, 0, 0]],
  ["arrowRight", word("run.rightE"), [0, -1, 0]],
];

/** Six buttons that push while they are held; those aside only for robots that can. */
export class Pad {
  readonly element = el("div", { class: "run-pad", role: "group", "aria-label": word("run.drive") });
  private readonly aside: HTMLButtonElement[] = [];

  constructor(wheel: Wheel) {
    for (const [picture, title, way] of WAYS) {
      const push = el("button", { type: "button", class: "square", title, "aria-label": title }, icon(picture));
      push.addEventListener("pointerdown", (event) => {
        event.preventDefault();
        push.setPointerCapture(event.pointerId);
        wheel.press(picture, way);
      });
      for (const end of ["pointerup", "pointercancel", "lostpointercapture"])
        push.addEventListener(end, () => wheel.release(picture));
      push.addEventListener("keydown", (event) => {
        if ((event.key === " " || event.key === "Enter") && !event.repeat) wheel.press(picture, way);
        if (event.key === " " || event.key === "Enter") event.stopPropagation();
      });
      push.addEventListener("keyup", () => wheel.release(picture));
      push.addEventListener("blur", () => wheel.release(picture));
      push.addEventListener("contextmenu", (event) => event.preventDefault());
      if (way[1]) this.aside.push(push);
      this.element.append(push);
    }
  }

  /** It makes way for a navigator, until somebody takes the robot from it by keys. */
  show(canDrive: boolean, navigator: string | null, driven: boolean): void {
    this.element.hidden = !canDrive || (navigator !== null && !driven);
  }

  canStrafe(can: boolean): void {
    for (const push of this.aside) push.style.visibility = can ? "" : "hidden";
  }
}
