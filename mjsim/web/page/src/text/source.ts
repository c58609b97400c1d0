/** The text of a module in a dialog, at the line where its class begins. */

import { el } from "../dom";
import { askWith } from "../shell/dialog";
import type { Studio } from "../shell/view";
import { word } from "../words/words";

export async function showSource(studio: Studio, use: string): Promise<void> {
  const { path, text } = studio.document;
  try {
    const source = await studio.api.source(path ?? "", text, use);
    const lines = source.text.split("\n").map((line, index) => {
      const begins = index + 1 === source.line;
      return el("li", begins ? { class: "begins" } : {}, `${line}\n`);
    });
    const list = el("ol", { class: "source mono", tabindex: "0", "aria-label": word("text.textOf", { name: source.name }) }, ...lines);
    const shown = askWith<void>(source.name, () => [list]);
    list.querySelector(".begins")?.scrollIntoView({ block: "start" });
    await shown;
  } catch (error) {
    studio.toasts.error(error);
  }
}
