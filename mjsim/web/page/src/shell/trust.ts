/** A world that names code beside it asks before that code first runs, and again when the code has changed. */

import { ApiError, type Code } from "../api";
import { ask } from "../ui/dialog";
import { el } from "../ui/dom";
import { word } from "../words/words";
import type { Studio } from "./view";

/** Code that a run was refused for, and the text that it was to run. */
export interface RunCode {
  code: Code;
  text: string;
}

/**
 * Let the person allow the world's own code; true when there is none, or it may run.
 *
 * What the dialog lists is allowed with the content that it had then; if that has changed meanwhile, the person is asked
 * again.
 */
export async function askTrust(studio: Studio, run?: RunCode): Promise<boolean> {
  const { document: world } = studio;
  await world.settled();
  let code = run?.code ?? world.parsed.needs_trust;
  while (Object.keys(code).length > 0) {
    if (!(await mayRun(code))) return false;
    try {
      await studio.api.trust(world.path ?? "", run?.text ?? world.text, code);
      await world.read();
      return true;
    } catch (error) {
      studio.toasts.error(error);
      const now = error instanceof ApiError && error.status === 409 ? error.data["needs_trust"] : undefined;
      if (!now) return false;
      code = now as Code;
    }
  }
  return true;
}

function mayRun(code: Code): Promise<boolean> {
  const body = [
    el("p", {}, word("shell.thisWorldBringsIts")),
    el("ul", {}, ...Object.keys(code).map((name) => el("li", { class: "mono" }, name))),
    el("p", { class: "hint" }, word("shell.allowItIfYou")),
  ];
  return ask(word("shell.letThisWorldsCode"), body, [
    { text: word("shell.notNow"), value: false },
    { text: word("shell.allow"), value: true, kind: "primary" },
  ]).then((answer) => answer === true);
}
