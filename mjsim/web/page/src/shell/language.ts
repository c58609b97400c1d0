/** The choice of the language of the page. */

import { sign } from "../ui/icons";
import { openMenu } from "../ui/menu";
import { html, type View } from "../ui/view";
import { choose, language, offered, word } from "../words/words";

/** A button of the bar with a menu of languages; null where there is one language only. */
export function languageButton(): View {
  const languages = offered();
  if (languages.length < 2) return null;
  const title = word("shell.language");
  const open = ({ currentTarget }: Event): void => {
    const entries = languages.map(([tag, text]) => ({ text, checked: tag === language, act: () => change(tag) }));
    const { left, bottom } = (currentTarget as Element).getBoundingClientRect();
    openMenu(title, [entries], [left, bottom + 4]);
  };
  return html`<button class="quiet square" title=${title} aria-label=${title} aria-haspopup="menu" @click=${open}
    >${sign("globe")}</button>`;
}

/** The page is loaded anew; the browser asks first where changes are not saved. */
function change(tag: string): void {
  if (tag === language) return;
  choose(tag);
  window.location.reload();
}
