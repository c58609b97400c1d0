/** Starting a run of the world that is open. */

import type { Studio } from "../shell/view";
import { said, word } from "../words/words";

/**
 * Begin with the world that is open, or is being opened, once its text is settled; say why not where it is wrong, or
 * where its code may not run.
 */
export async function startWorld(studio: Studio, begin: (path: string, text: string) => Promise<void>): Promise<void> {
  const { document, toasts } = studio;
  await studio.settled();
  const { path, text, parsed } = document;
  if (path === null) return toasts.error(word("run.noWorldIsOpenOpen"));
  const wrong = parsed.problems.find((problem) => problem.kind === "error");
  if (wrong) return toasts.error(word("run.lineOfTheWorldIs", { line: wrong.line, message: said(wrong.message) }));
  if (Object.keys(parsed.needs_trust).length && !(await studio.askTrust())) return;
  await begin(path, text);
}
