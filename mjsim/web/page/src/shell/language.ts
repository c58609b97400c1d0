/** The choice of the language of the page. */

import { el } from "../ui/dom";
import { icon } from "../ui/icons";
import { openMenu } from "../ui/menu";
import { choose, language, offered, word } from "../words/words";

/** A button of the bar with a menu of languages; null where there is one language only. */
export function languageButton(): HTMLButtonElement | null {
  const languages = offered();
  if (languages.length < 2) return null;
  const title = word("shell.language");
  const open = (): void => {
    const entries = languages.map(([tag, text]) => ({ text, checked: tag === language, act: () => change(tag) }));
    const { left, bottom } = button.getBoundingClientRect();
    openMenu(title, [entries], [left, bottom + 4]);
  };
  const attributes = { class: "quiet square", title, "aria-label": title, "aria-haspopup": "menu", onclick: open };
  const button = el("button", attributes, icon("globe"));
  return button;
}

/** The page is loaded anew; the browser asks first where changes are not saved. */
function change(tag: string): void {
  if (tag === language) return;
  choose(tag);
  window.location.reload();
}
