/** What the Edit view shows before a world is open: how to begin. */

import { el, icon } from "../dom";
import { ICONS } from "../shell/icons";
import { isNew, takeTour } from "../shell/tour";
import type { Studio } from "../shell/view";

export function emptyState(studio: Studio): HTMLElement {
  const { worlds, shipped, folder } = studio.folder;
  const open = async (path: string): Promise<void> => {
    try {
      studio.document.take(await studio.api.open(path));
    } catch (error) {
      studio.toasts.error(error);
    }
  };
  const create = async (): Promise<void> => {
    try {
      studio.document.take(await studio.api.create(), true);
    } catch (error) {
      studio.toasts.error(error);
    }
  };
  const own = worlds.slice(0, 6).map((world) => el("button", { onclick: () => void open(world) }, world));
  const example = shipped.worlds.includes("gallery") ? "gallery" : shipped.worlds[0];
  return el(
    "div",
    { class: "state start" },
    el("h2", {}, "Build a room for your robot"),
    el(
      "p",
      { class: "hint" },
      "Draw walls, hang up pictures, put a robot in, and let it drive. Or look at a world that is there.",
    ),
    el(
      "div",
      { class: "row" },
      el("button", { class: "primary", onclick: () => void create() }, icon(ICONS.new), "New world"),
      example
        ? el("button", { onclick: () => void open(`shipped:${example}`) }, icon(ICONS.open), `See the ${example}`)
        : null,
      el("button", { onclick: () => void studio.askNew() }, "Begin with a template"),
    ),
    isNew() ? tourOffer(studio) : null,
    own.length ? el("p", { class: "list-title" }, `In ${folder}`) : null,
    el("div", { class: "row" }, ...own),
  );
}

/** Offered until somebody takes it; after that it is found in the help. */
function tourOffer(studio: Studio): HTMLElement {
  return el(
    "p",
    { class: "tour-offer" },
    "New here? ",
    el("button", { onclick: () => void takeTour(studio) }, "Take the tour in six steps"),
  );
}
