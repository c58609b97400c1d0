/** The Edit view. */

import { el } from "../dom";
import { Plan } from "../plan/plan";
import type { Studio, View } from "../shell/view";

export function makeEditView(studio: Studio): View {
  const host = el("div", { class: "plan", tabindex: 0 });
  const element = el("section", { class: "view edit", "aria-label": "Edit" }, host);
  const plan = new Plan(host);
  studio.document.opened.on(() => plan.forgetView());
  studio.document.parsedChanged.on(() => plan.setItems(studio.document.items, studio.document.parsed.bounds));
  return { element, shown: () => plan.refresh(), hidden: () => undefined, key: (event) => plan.key(event) };
}
