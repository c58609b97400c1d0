/** The bar between plan and text: dragged, or moved by arrow keys. */

import { word } from "../words/words";
import { el } from "./dom";

/** The text is at least so large [px]. */
const LEAST = 90;

export function splitter(view: HTMLElement): HTMLElement {
  const bar = el("div", {
    class: "splitter",
    role: "separator",
    tabindex: 0,
    "aria-label": word("edit.sizeOfTheText"),
    "aria-valuenow": 200,
    "aria-valuemin": LEAST,
    "aria-valuemax": 2000,
  });
  const isWide = (): boolean => getComputedStyle(bar).cursor === "col-resize";
  const size = (pixels: number): void => {
    const most = isWide() ? view.clientWidth * 0.5 : view.clientHeight * 0.7;
    const wanted = Math.round(Math.min(Math.max(pixels, LEAST), most));
    view.style.setProperty(isWide() ? "--text-width" : "--text-height", `${wanted}px`);
    bar.setAttribute("aria-valuenow", String(wanted));
  };
  const now = (): number => {
    const dock = bar.nextElementSibling;
    return dock ? (isWide() ? dock.clientWidth : dock.clientHeight) : 200;
  };
  bar.addEventListener("pointerdown", (event) => {
    bar.setPointerCapture(event.pointerId);
    const [start, from] = [now(), isWide() ? event.clientX : event.clientY];
    const move = (moved: PointerEvent): void => size(start + from - (isWide() ? moved.clientX : moved.clientY));
    bar.addEventListener("pointermove", move);
    const end = (): void => bar.removeEventListener("pointermove", move);
    bar.addEventListener("pointerup", end, { once: true });
    bar.addEventListener("pointercancel", end, { once: true });
  });
  bar.addEventListener("keydown", (event) => {
    const step = { ArrowUp: 24, ArrowLeft: 24, ArrowDown: -24, ArrowRight: -24 }[event.key];
    if (!step) return;
    event.preventDefault();
    event.stopPropagation();
    size(now() + step);
  });
  return bar;
}
