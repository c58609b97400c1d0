/** The recordings of the folder, and a place to drop another. */

import { ApiError } from "../api";
import { el, fill } from "../dom";
import type { Studio } from "../shell/view";

export class Library {
  readonly element = el("div", { class: "run-library" });
  private readonly list = el("ul", {});
  private readonly hint = el("p", { class: "hint" });

  constructor(
    private readonly studio: Studio,
    private readonly open: (path: string) => void,
  ) {
    this.element.append(this.list, this.hint);
  }

  show(chosen: string | null): void {
    const { recordings } = this.studio.folder;
    fill(this.list, ...recordings.map((path) => el("li", {}, this.entry(path, path === chosen))));
    this.hint.textContent = recordings.length
      ? "Or drop an .mcap file anywhere on this page."
      : "There is no recording in this folder yet. Run a world with “Record to a file”, or drop an .mcap file here.";
  }

  /** Let recordings be dropped on an element. */
  takeDrops(place: HTMLElement): void {
    const over = (on: boolean) => (event: DragEvent) => {
      if (!event.dataTransfer?.types.includes("Files")) return;
      event.preventDefault();
      place.toggleAttribute("data-dropping", on);
    };
    place.addEventListener("dragover", over(true));
    place.addEventListener("dragleave", over(false));
    place.addEventListener("drop", (event) => {
      over(false)(event);
      const file = event.dataTransfer?.files[0];
      if (file) void this.upload(file);
    });
  }

  private entry(path: string, chosen: boolean): HTMLButtonElement {
    const cut = path.lastIndexOf("/") + 1;
    return el(
      "button",
      {
        type: "button",
        class: "quiet",
        title: path,
        "data-path": path,
        "aria-current": chosen ? "true" : null,
        onclick: () => this.open(path),
      },
      el("b", {}, path.slice(cut)),
      el("span", { class: "hint" }, path.slice(0, cut)),
    );
  }

  private async upload(file: File): Promise<void> {
    // One that lies in the folder already need not be sent.
    const there = this.studio.folder.recordings.filter((path) => path.split("/").pop() === file.name);
    if (there.length === 1 && there[0]) return this.open(there[0]);
    try {
      const address = `/api/recording/upload?${new URLSearchParams({ name: file.name })}`;
      const response = await fetch(address, { method: "POST", body: file }).catch(() => null);
      const answer = (await response?.json().catch(() => ({}))) as { path?: string; error?: string } | undefined;
      if (!response?.ok || !answer?.path)
        throw new ApiError(
          response?.status ?? 0,
          answer?.error ?? `${file.name} could not be taken; copy it into the folder, then open it from the list`,
        );
      await this.studio.refresh();
      this.open(answer.path);
    } catch (error) {
      this.studio.toasts.error(error);
    }
  }
}
