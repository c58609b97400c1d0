/** Keys of input methods: while one composes a word, keys are its own, and no view hears them. */

/** What keys are called that an input method has taken; Safari tells of the last one when the word is there. */
const TAKEN = 229;

/** Keep them from all views but the text of the world, whose editor minds them itself. */
export function heedInputMethods(): void {
  const heed = (event: KeyboardEvent): void => {
    const isComposing = event.isComposing || event.keyCode === TAKEN;
    const isText = event.target instanceof Element && event.target.closest(".cm-editor");
    if (isComposing && !isText) event.stopImmediatePropagation();
  };
  window.addEventListener("keydown", heed, { capture: true });
}
