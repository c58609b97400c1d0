/** What the Edit view shows before a world is open: how to begin. */

import type { Opened } from "../api";
import { isNew, takeTour } from "../shell/tour";
import type { Studio } from "../shell/view";
import { el } from "../ui/dom";
import { sign } from "../ui/icons";
import { draw, html, nothing, type View } from "../ui/view";
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
  const button = (press: () => unknown, label: View, kind = ""): View =>
    html`<button class=${kind} @click=${press}>${label}</button>`;
  const own = worlds.slice(0, 6).map((world) => button(() => open(world), world));
  const example = shipped.worlds.includes("gallery") ? "gallery" : shipped.worlds[0];
  const seen = [sign("open"), word("edit.seeThe", { example })];
  const place = el("div", { class: "state start" });
  const view = html`<h2>${word("edit.buildARoomForYour")}</h2><p class="hint">${word("edit.drawWallsHangUpPictures")}</p>
      <div class="row">${button(create, [sign("new"), word("edit.newWorld")], "primary")}
        ${example ? button(() => open(`shipped:${example}`), seen) : nothing}
        ${button(() => studio.askNew(), word("edit.beginWithATemplate"))}</div>
      ${isNew() ? tourOffer(studio) : nothing}
      ${own.length ? html`<p class="list-title">${word("edit.in", { folder })}</p>` : nothing}<div class="row">${own}</div>`;
  draw(place, view);
  return place;
}

/** Offered until somebody takes it; after that it is found in the help. */
function tourOffer(studio: Studio): View {
  return html`<p class="tour-offer">${word("edit.newHere")}<button @click=${() => takeTour(studio)}
    >${word("edit.takeTheTourInSix")}</button></p>`;
}
