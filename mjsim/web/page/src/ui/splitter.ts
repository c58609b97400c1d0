/** A bar beside a panel: dragged, or moved by arrow keys, it gives the panel its size, which is kept; a double click resets it. */

import { remembered } from "./controls";
import { el } from "./dom";

/** A panel is at least so large [px], and at most this share of its view. */
const LEAST = 90;
const MOST = 0.7;
/** An arrow key moves the bar by so much [px]. */
const STEP = 24;
const KEYS: Record<string, number> = { ArrowUp: -STEP, ArrowLeft: -STEP, ArrowDown: STEP, ArrowRight: STEP };

export interface Split {
  /** What screen readers call it, as "Size of the text". */
  label: string;
  /** Whose size it is, before the bar or after it; unless given what stands before it. */
  panel?: HTMLElement;
  /** Properties of the view's style for the panel's height and width, of which its layout uses one at a time. */
  height?: string;
  width?: string;
}

export function splitter(view: HTMLElement, { label, panel: own, height, width }: Split): HTMLElement {
  const bar = el("div", {
    class: "splitter",
    role: "separator",
    tabindex: 0,
    "aria-label": label,
    "aria-valuenow": 200,
    "aria-valuemin": LEAST,
    "aria-valuemax": 2000,
  });
  const keyOf = (name: string): string => `size.${view.classList[1] ?? view.className}${name}`;
  const names = [height, width].filter((name) => name !== undefined);
  for (const name of names) if (remembered(keyOf(name))) view.style.setProperty(name, remembered(keyOf(name)));
  const panel = (): HTMLElement => own ?? (bar.previousElementSibling as HTMLElement);
  const isUpright = (): boolean => getComputedStyle(bar).cursor === "col-resize";
  const now = (): number => (isUpright() ? panel().offsetWidth : panel().offsetHeight);
  // A panel may have been put to the other side.
  const way = (): number => {
    const [mine, its] = [bar.getBoundingClientRect(), panel().getBoundingClientRect()];
    return (isUpright() ? its.left < mine.left : its.top < mine.top) ? 1 : -1;
  };
  const size = (pixels: number): void => {
    const most = MOST * (isUpright() ? view.clientWidth : view.clientHeight);
    const wanted = Math.round(Math.min(Math.max(pixels, LEAST), most));
    const name = isUpright() ? width : height;
    if (!name) return;
    view.style.setProperty(name, `${wanted}px`);
    remembered(keyOf(name), `${wanted}px`);
    bar.setAttribute("aria-valuenow", String(wanted));
  };
  bar.addEventListener("pointerdown", (event) => {
    bar.setPointerCapture(event.pointerId);
    const [start, from] = [now(), isUpright() ? event.clientX : event.clientY];
    const move = (moved: PointerEvent): void =>
      size(start + way() * ((isUpright() ? moved.clientX : moved.clientY) - from));
    bar.addEventListener("pointermove", move);
    const end = (): void => bar.removeEventListener("pointermove", move);
    bar.addEventListener("pointerup", end, { once: true });
    bar.addEventListener("pointercancel", end, { once: true });
  });
  bar.addEventListener("keydown", (event) => {
    const step = KEYS[event.key];
    if (!step) return;
    event.preventDefault();
    event.stopPropagation();
    size(now() + way() * step);
  });
  bar.addEventListener("dblclick", () => {
    for (const name of names) {
      view.style.removeProperty(name);
      remembered(keyOf(name), "");
    }
  });
  bar.addEventListener("focus", () => bar.setAttribute("aria-orientation", isUpright() ? "vertical" : "horizontal"));
  return bar;
}
