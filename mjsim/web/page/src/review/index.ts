/** The Review view. */

import { el } from "../dom";
import type { Studio, View } from "../shell/view";

export function makeReviewView(_studio: Studio): View {
  const element = el("section", { class: "view review", "aria-label": "Review" });
  return { element, shown: () => undefined, hidden: () => undefined };
}
