/** Switches for the charts of a sheet, as the browser remembers them. */

import { remembered, toggle } from "../ui/controls";
import { el } from "../ui/dom";
import { word } from "../words/words";
import { KINDS, type Kind, type Sheet } from "./sheet";

export function chartChips(key: string, first: Kind[], sheet: Sheet, changed: () => void): HTMLElement {
  const kept = remembered(key)?.split(" ") ?? first;
  const now = new Set(KINDS.map(({ kind }) => kind).filter((kind) => kept.includes(kind)));
  sheet.choose([...now]);
  const press = (kind: Kind, on: boolean): void => {
    if (on) now.add(kind);
    else now.delete(kind);
    const kinds = KINDS.map((each) => each.kind).filter((each) => now.has(each));
    remembered(key, kinds.join(" "));
    sheet.choose(kinds);
    changed();
  };
  const chips = KINDS.map(({ kind, label }) =>
    toggle({ class: "quiet run-small", hidden: true }, now.has(kind), (on) => press(kind, on), label),
  );
  sheet.offered.on((kinds) => {
    for (const [k, { kind }] of KINDS.entries()) chips[k]?.toggleAttribute("hidden", !kinds.includes(kind));
  });
  return el("div", { class: "run-chips", role: "group", "aria-label": word("charts.charts") }, ...chips);
}
