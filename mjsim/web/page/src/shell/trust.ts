/** A world that names code beside it asks once before that code first runs. */

import { el } from "../dom";
import { ask } from "./dialog";
import type { Studio } from "./view";

/** Let the person allow the world's own code; true when there is none, or it may run. */
export async function askTrust(studio: Studio): Promise<boolean> {
  const { document: world } = studio;
  await world.settled();
  const files = world.parsed.needs_trust;
  if (files.length === 0) return true;
  const body = [
    el("p", {}, "This world brings its own code, which can do on this computer what you can do:"),
    el("ul", {}, ...files.map((file) => el("li", { class: "mono" }, file))),
    el(
      "p",
      { class: "hint" },
      "Allow it if you wrote it, or read it and trust where it comes from. It stays allowed while the studio is open.",
    ),
  ];
  const answer = await ask("Let this world's code run?", body, [
    { text: "Not now", value: false },
    { text: "Allow", value: true, kind: "primary" },
  ]);
  if (!answer) return false;
  try {
    await studio.api.trust(world.path ?? "", world.text);
    await world.read();
    return true;
  } catch (error) {
    studio.toasts.error(error);
    return false;
  }
}
