/** At which side of the plan the text and the panels stand: dragged there by their heads, or put there by keys, and kept. */

import { remembered } from "../ui/controls";
import { draggedBy } from "../ui/dragging";

type Part = "text" | "column";

/** From so wide a window on [px] the text stands at the right, unless somebody has put it elsewhere. */
const WIDE = 1560;
const ARROWS: Record<Part, Record<string, string>> = {
  text: { ArrowRight: "right", ArrowDown: "bottom" },
  column: { ArrowLeft: "left", ArrowRight: "right" },
};

/** The side that a part is dropped at, by where that is in the view, as shares of its width and height. */
export function sideOf(part: Part, x: number, y: number): string {
  if (part === "column") return x < 0.5 ? "left" : "right";
  return x > y ? "right" : "bottom";
}

/** @param heads what each part is dragged by; keys of what is in its parent count too */
export function letSidesBeChosen(view: HTMLElement, heads: Record<Part, HTMLElement>, changed: () => void): void {
  const wide = window.matchMedia(`(min-width: ${WIDE}px)`);
  const usual = (part: Part): string => (part === "column" || wide.matches ? "right" : "bottom");
  const arrange = (): void => {
    for (const part of ["text", "column"] as const) view.dataset[part] = remembered(`edit.${part}`) || usual(part);
    changed();
  };
  const put = (part: Part, side: string): void => {
    remembered(`edit.${part}`, side);
    arrange();
  };
  for (const [part, head] of Object.entries(heads) as [Part, HTMLElement][]) {
    const at = ({ clientX, clientY }: PointerEvent): string => {
      const { left, top, width, height } = view.getBoundingClientRect();
      return sideOf(part, (clientX - left) / width, (clientY - top) / height);
    };
    draggedBy(head, {
      over: (event) => (event ? view.setAttribute("data-drop", at(event)) : view.removeAttribute("data-drop")),
      drop: (event) => put(part, at(event)),
    });
    head.parentElement?.addEventListener("keydown", (event) => {
      const side = ARROWS[part][event.key];
      if (!side || !event.ctrlKey || !(event.target as Element).matches("button")) return;
      event.preventDefault();
      event.stopPropagation();
      put(part, side);
    });
  }
  wide.addEventListener("change", arrange);
  arrange();
}
