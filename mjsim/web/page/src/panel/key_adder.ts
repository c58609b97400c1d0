/** Puts an entry into a map of the world, under a key that it may have or one of the person's own. */

import type { Path } from "../api";
import { keyOf } from "../plan/plan";
import { el } from "../ui/dom";
import { icon } from "../ui/icons";
import { word } from "../words/words";
import type { Sheet } from "./rows";
import { labelOf, type Schema } from "./schema";

/** A field for the key and a button; `names` are offered, and a module is chosen before it is written. */
export function keyAdder(sheet: Sheet, path: Path, list: string, entry: Schema, names: string[]): HTMLElement {
  const id = `${keyOf(path)} key`;
  const isModule = sheet.book.field("", entry, true).kind.is === "module";
  const add = async (): Promise<void> => {
    const key = input.value.trim();
    if (!key) return input.focus();
    const chosen = isModule ? await sheet.tools.chooseModule([...path, key]) : { value: sheet.book.fresh(entry, key) };
    if (chosen && chosen.value !== undefined) sheet.change([{ op: "set", path: [...path, key], value: chosen.value }]);
  };
  const input = el("input", {
    "data-id": id,
    list: `${id}-offers`,
    value: names.length === 1 ? names[0] : "",
    placeholder: names[0] ?? word("panel.name"),
    "aria-label": word("panel.newKeyOf", { list }),
    autocomplete: "off",
    spellcheck: "false",
  });
  input.addEventListener("keydown", (event) => event.key === "Enter" && void add());
  const button = el(
    "button",
    { type: "button", class: "quiet add", "data-id": `${id} add`, onclick: () => void add() },
    icon("plus"),
    word("panel.add"),
  );
  const offers = el(
    "datalist",
    { id: `${id}-offers` },
    ...names.map((value) => el("option", { value }, labelOf(value))),
  );
  return el("div", { class: "key-adder" }, input, offers, button);
}
