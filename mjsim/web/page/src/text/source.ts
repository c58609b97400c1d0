/** The text of a module or an included file in a dialog, at the line of what was asked for. */

import type { Studio } from "../shell/view";
import { askWith } from "../ui/dialog";
import { el } from "../ui/dom";
import { word } from "../words/words";

export async function showSource(studio: Studio, use: string): Promise<void> {
  const { path, text } = studio.document;
  try {
    const source = await studio.api.source(path ?? "", text, use);
    await showText(source.name, source.text, source.line);
  } catch (error) {
    studio.toasts.error(error);
  }
}

/** Show a text in a dialog, with one of its lines marked and in sight, counted from 1. */
export async function showText(name: string, text: string, marked: number): Promise<void> {
  const lines = text.split("\n").map((line, index) => {
    const begins = index + 1 === marked;
    return el("li", begins ? { class: "begins" } : {}, `${line}\n`);
  });
  const list = el("ol", { class: "source mono", tabindex: "0", "aria-label": word("text.textOf", { name }) }, ...lines);
  const shown = askWith<void>(name, () => [list]);
  list.querySelector(".begins")?.scrollIntoView({ block: "start" });
  await shown;
}
