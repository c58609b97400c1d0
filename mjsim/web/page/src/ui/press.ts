/** A press of the pointer counts where it was begun: what moves away from under it meanwhile is clicked all the same. */

const PRESSED = "button, summary, a[href], label, input:is([type='checkbox'], [type='radio'])";

/** A place [px]. */
export interface Point {
  clientX: number;
  clientY: number;
}

/** Whether a pointer is still where something was when it was pressed. */
export function isWithin({ left, right, top, bottom }: DOMRect, { clientX, clientY }: Point): boolean {
  return left <= clientX && clientX <= right && top <= clientY && clientY <= bottom;
}

export function heedPresses(): void {
  let [pressed, box]: [HTMLElement | null, DOMRect | null] = [null, null];
  const press = (event: PointerEvent): void => {
    pressed = event.button === 0 && event.target instanceof Element ? event.target.closest<HTMLElement>(PRESSED) : null;
    box = pressed?.getBoundingClientRect() ?? null;
  };
  const release = (event: PointerEvent): void => {
    if (pressed && box && isWithin(box, event) && isMissed(pressed, event)) pressed.click();
    pressed = null;
  };
  window.addEventListener("pointerdown", press, { capture: true });
  window.addEventListener("pointerup", release, { capture: true });
  window.addEventListener("pointercancel", () => (pressed = null), { capture: true });
}

/** Whether the browser clicks something else, although nothing was put in front of all of it. */
function isMissed(pressed: HTMLElement, event: PointerEvent): boolean {
  const hit = document.elementFromPoint(event.clientX, event.clientY);
  const isTaken = event.pointerType === "mouse" && pressed.hasPointerCapture(event.pointerId);
  const dialog = document.querySelector("dialog:modal");
  return !pressed.contains(hit) && !isTaken && pressed.checkVisibility() && (!dialog || dialog.contains(pressed));
}
