/** Puts an entry into a map of the world, under a key that it may have or one of the person's own. */

import type { Path } from "../api";
import { keyOf } from "../plan/plan";
import { sign } from "../ui/icons";
import { html, typed, type View } from "../ui/view";
import { word } from "../words/words";
import type { Sheet } from "./rows";
import { labelOf, type Schema } from "./schema";

/** A field for the key and a button; `names` are offered, and a module is chosen before it is written. */
export function keyAdder(sheet: Sheet, path: Path, list: string, entry: Schema, names: string[]): View {
  const offers = `${keyOf(path)}-keys`;
  const isModule = sheet.book.field("", entry, true).kind.is === "module";
  const add = async ({ currentTarget }: Event): Promise<void> => {
    const input = (currentTarget as HTMLElement).parentElement?.querySelector("input");
    const key = input?.value.trim();
    if (!input || !key) return input?.focus();
    const chosen = isModule ? await sheet.tools.chooseModule([...path, key]) : { value: sheet.book.fresh(entry, key) };
    if (chosen?.value === undefined) return;
    input.value = input.defaultValue;
    sheet.change([{ op: "set", path: [...path, key], value: chosen.value }]);
  };
  return html`<div class="key-adder"><input list=${offers} ${typed(names.length === 1 ? (names[0] ?? "") : "")}
    placeholder=${names[0] ?? word("panel.name")} aria-label=${word("panel.newKeyOf", { list })} autocomplete="off"
    spellcheck="false" @keydown=${(event: KeyboardEvent) => event.key === "Enter" && void add(event)}>
    <datalist id=${offers}>${names.map((value) => html`<option value=${value}>${labelOf(value)}</option>`)}</datalist>
    <button type="button" class="quiet add" @click=${add}>${sign("plus")}${word("panel.add")}</button></div>`;
}
