/** The Run view. */

import { el } from "../dom";
import type { Studio, View } from "../shell/view";

export function makeRunView(_studio: Studio): View {
  const element = el("section", { class: "view run", "aria-label": "Run" });
  return { element, shown: () => undefined, hidden: () => undefined };
}
