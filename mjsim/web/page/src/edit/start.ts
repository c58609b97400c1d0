/** What the Edit view shows before a world is open: how to begin. */

import type { Opened } from "../api";
import { isNew, takeTour } from "../shell/tour";
import type { Studio } from "../shell/view";
import { el } from "../ui/dom";
import { icon } from "../ui/icons";
import { word } from "../words/words";

export function emptyState(studio: Studio): HTMLElement {
  const { worlds, shipped, folder } = studio.folder;
  const begin = async (get: () => Promise<Opened>, isNew: boolean): Promise<void> => {
    try {
      const world = await get();
      // Another one may have been opened meanwhile.
      if (!studio.document.isOpen) studio.document.take(world, isNew);
    } catch (error) {
      studio.toasts.error(error);
    }
  };
  const open = (path: string): Promise<void> => begin(() => studio.api.open(path), false);
  const create = (): Promise<void> => begin(() => studio.api.create(), true);
  const own = worlds.slice(0, 6).map((world) => el("button", { onclick: () => void open(world) }, world));
  const example = shipped.worlds.includes("gallery") ? "gallery" : shipped.worlds[0];
  return el(
    "div",
    { class: "state start" },
    el("h2", {}, word("edit.buildARoomForYour")),
    el("p", { class: "hint" }, word("edit.drawWallsHangUpPictures")),
    el(
      "div",
      { class: "row" },
      el("button", { class: "primary", onclick: () => void create() }, icon("new"), word("edit.newWorld")),
      example
        ? el(
            "button",
            { onclick: () => void open(`shipped:${example}`) },
            icon("open"),
            word("edit.seeThe", { example }),
          )
        : null,
      el("button", { onclick: () => void studio.askNew() }, word("edit.beginWithATemplate")),
    ),
    isNew() ? tourOffer(studio) : null,
    own.length ? el("p", { class: "list-title" }, word("edit.in", { folder })) : null,
    el("div", { class: "row" }, ...own),
  );
}

/** Offered until somebody takes it; after that it is found in the help. */
function tourOffer(studio: Studio): HTMLElement {
  return el(
    "p",
    { class: "tour-offer" },
    word("edit.newHere"),
    el("button", { onclick: () => void takeTour(studio) }, word("edit.takeTheTourInSix")),
  );
}
