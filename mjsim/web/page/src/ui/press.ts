/** What is pressed: a control that is replaced before it is let go takes its click along, so drawing waits. */

let pressed: Element | null = null;
/** Drawings that wait, the last one of each place. */
const held = new Map<Element, () => void>();

/** Draw what is in a place; while something there is pressed, once it is let go. */
export function unpressed(place: Element, draw: () => void): void {
  if (pressed && place.contains(pressed)) held.set(place, draw);
  else draw();
}

/** Know from now on what is pressed, by pointer or by the space bar. */
export function heedPresses(): void {
  const press = ({ target }: Event): void => {
    pressed = target instanceof Element ? target : null;
  };
  const release = (): void => {
    pressed = null;
    const waiting = [...held.values()];
    held.clear();
    for (const draw of waiting) draw();
  };
  const listen = (kind: string, heed: (event: Event) => void): void =>
    window.addEventListener(kind, heed, { capture: true });
  listen("pointerdown", press);
  listen("keydown", (event) => (event as KeyboardEvent).key === " " && press(event));
  // A click comes after both, and knows its way through what is replaced now; not every press ends in one.
  listen("click", release);
  for (const kind of ["pointerup", "keyup"]) listen(kind, () => pressed && window.setTimeout(release));
  // A list that opens in a window of its own takes the end of its press along.
  listen("pointermove", (event) => pressed && !(event as PointerEvent).buttons && release());
  listen("change", (event) => event.target === pressed && release());
  for (const kind of ["pointercancel", "blur"]) window.addEventListener(kind, release);
}
