/** Something is dragged by its head, with mouse, pen or finger; Escape gives it up. */

/** Nearer than this to where it was pressed, a head was clicked [px]. */
const SLACK = 6;

export interface Drag {
  /** Told where the pointer is; null where nothing is dragged any more. */
  over: (at: PointerEvent | null) => void;
  drop: (at: PointerEvent) => void;
}

export function draggedBy(head: HTMLElement, { over, drop }: Drag): void {
  let [start, isDragged]: [PointerEvent | null, boolean] = [null, false];
  const end = (): void => {
    start = null;
    window.removeEventListener("keydown", giveUp, { capture: true });
    over(null);
  };
  const giveUp = (event: KeyboardEvent): void => {
    if (event.key === "Escape") end();
  };
  head.classList.add("dragged-by");
  head.addEventListener("pointerdown", (event) => {
    isDragged = false;
    if (event.button !== 0) return;
    start = event;
    head.setPointerCapture(event.pointerId);
    window.addEventListener("keydown", giveUp, { capture: true });
  });
  head.addEventListener("pointermove", (event) => {
    if (!start) return;
    isDragged ||= Math.hypot(event.clientX - start.clientX, event.clientY - start.clientY) > SLACK;
    if (isDragged) over(event);
  });
  head.addEventListener("pointerup", (event) => {
    if (start && isDragged) drop(event);
    end();
  });
  head.addEventListener("pointercancel", end);
  // What was dragged was not clicked.
  head.addEventListener("click", (event) => isDragged && event.stopImmediatePropagation(), { capture: true });
}
