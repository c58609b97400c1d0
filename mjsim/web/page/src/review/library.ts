/** The recordings of the folder, and a place to drop another. */

import { ApiError } from "../api";
import type { Studio } from "../shell/view";
import { button } from "../ui/controls";
import { el, refill } from "../ui/dom";
import { theme, themeChanged } from "../ui/theme";
import { heard, said, word } from "../words/words";
import { factsOf, type RecordingCard } from "./facts";
import { recordings } from "./recording";

/** Fewer recordings are found without a search. */
const FEW = 6;

export class Library {
  readonly element = el("div", { class: "run-library" });
  private readonly list = el("ul", {});
  private readonly sweeps = el("div", {});
  /** Paths that are ticked. */
  private readonly ticked = new Set<string>();
  private readonly go = button({ class: "primary" }, () => void this.begin(), word("review.compare"));
  private readonly every = button({ class: "quiet run-small" }, () => this.tickAll(), word("review.tickAll"));
  private readonly foot = el("div", { class: "run-compare", hidden: true }, this.every, this.go);
  private readonly hint = el("p", { class: "hint" });
  /** What recordings are of, the newest first. */
  private cards: RecordingCard[] = [];
  private readonly search = el("input", {
    type: "search",
    hidden: true,
    placeholder: word("review.findARecording"),
    "aria-label": word("review.findARecording"),
    oninput: () => this.filter(),
  });

  constructor(
    private readonly studio: Studio,
    private readonly open: (path: string) => void,
    private readonly compare: (paths: string[]) => Promise<void>,
  ) {
    themeChanged.on(() => {
      for (const picture of this.list.querySelectorAll("img"))
        picture.src = recordings.plan(picture.dataset["of"] ?? "", theme());
    });
    this.element.append(this.search, this.list, this.sweeps, this.hint, this.foot);
  }

  /** Ask what the recordings are of. */
  async load(): Promise<void> {
    this.cards = await recordings.cards();
  }

  show(chosen: string | null): void {
    const { recordings, sweeps } = this.studio.folder;
    const newest = [...new Set([...this.cards.map(({ path }) => path), ...recordings])].filter((path) =>
      recordings.includes(path),
    );
    for (const path of this.ticked) if (!recordings.includes(path) && !sweeps.includes(path)) this.ticked.delete(path);
    refill(this.list, ...newest.map((path) => el("li", {}, this.box(path), this.entry(path, path === chosen))));
    const swept = sweeps.map((path) => el("li", {}, el("label", {}, this.box(path), path)));
    refill(
      this.sweeps,
      sweeps.length > 0 && el("h2", {}, word("review.sweeps")),
      sweeps.length > 0 && el("ul", {}, ...swept),
    );
    this.foot.hidden = recordings.length + sweeps.length === 0;
    this.search.hidden = recordings.length < FEW;
    this.filter();
    this.count();
    this.hint.textContent = recordings.length ? word("review.orDropAnMcapFile") : word("review.thereIsNoRecordingIn");
  }

  /** Focus the button that starts a comparison. */
  focus(): void {
    this.go.focus({ preventScroll: true });
  }

  /** Let recordings be dropped on an element. */
  takeDrops(place: HTMLElement): void {
    const over = (on: boolean) => (event: DragEvent) => {
      if (!event.dataTransfer?.types.includes("Files")) return;
      event.preventDefault();
      place.dataset["drop"] = word("review.dropTheRecording");
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

  /** Show those whose name, folder, date, world or robots have all words that are searched for. */
  private filter(): void {
    const words = this.search.hidden ? [] : this.search.value.toLowerCase().split(/\s+/);
    for (const entry of this.list.children) {
      const text = (entry.textContent ?? "").toLowerCase();
      entry.toggleAttribute("hidden", !words.every((part) => text.includes(part)));
    }
  }

  private box(path: string): HTMLInputElement {
    const box = el("input", {
      type: "checkbox",
      checked: this.ticked.has(path),
      "aria-label": word("review.compare2", { path }),
    });
    box.addEventListener("change", () => {
      if (box.checked) this.ticked.add(path);
      else this.ticked.delete(path);
      this.count();
    });
    return box;
  }

  /** Tick all recordings, or none where all are. */
  private tickAll(): void {
    const { recordings } = this.studio.folder;
    const all = recordings.every((path) => this.ticked.has(path));
    this.ticked.clear();
    if (!all) for (const path of recordings) this.ticked.add(path);
    for (const box of this.list.querySelectorAll("input")) box.checked = !all;
    for (const box of this.sweeps.querySelectorAll("input")) box.checked = false;
    this.count();
  }

  /** Compare what is ticked; many recordings take a while to read. */
  private async begin(): Promise<void> {
    this.go.disabled = true;
    this.go.textContent = word("review.reading");
    await this.compare([...this.ticked]);
    this.count();
  }

  /** Two runs can be compared, and a sweep alone. */
  private count(): void {
    const paths = [...this.ticked];
    const enough = paths.length > 1 || paths.some((path) => this.studio.folder.sweeps.includes(path));
    this.go.disabled = !enough;
    const all = this.studio.folder.recordings.every((path) => this.ticked.has(path));
    this.every.textContent = all ? word("review.tickNone") : word("review.tickAll");
    this.go.textContent = enough
      ? word("review.compareChosen", { paths: paths.length })
      : word("review.compareTickTwoOrMore");
  }

  private entry(path: string, chosen: boolean): HTMLButtonElement {
    const cut = path.lastIndexOf("/") + 1;
    const card = this.cards.find((each) => each.path === path);
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
      card?.world
        ? el("img", { src: recordings.plan(path, theme()), alt: "", loading: "lazy", "data-of": path })
        : null,
      el("b", {}, path.slice(cut)),
      el("span", { class: "hint" }, path.slice(0, cut)),
      card
        ? el("span", { class: "run-facts" }, ...factsOf(card).map((fact) => el("span", { class: "hint" }, fact)))
        : null,
    );
  }

  /** Return the path of a dropped file if it is in the folder already; a file of the same name may be another one. */
  private async found({ name, size }: File): Promise<string | null> {
    for (const path of this.studio.folder.recordings.filter((each) => each.split("/").pop() === name)) {
      const there = await recordings.open(path).catch(() => null);
      if (there?.bytes === size) return path;
    }
    return null;
  }

  private async upload(file: File): Promise<void> {
    try {
      const there = await this.found(file);
      if (there !== null) return this.open(there);
      const address = `/api/recording/upload?${new URLSearchParams({ name: file.name })}`;
      const response = await fetch(address, { method: "POST", body: file }).catch(() => null);
      const answer = heard((await response?.json().catch(() => ({}))) as { path?: string; error?: string } | undefined);
      if (!response?.ok || !answer?.path)
        throw new ApiError(
          response?.status ?? 0,
          answer?.error ? said(answer.error) : word("review.couldNotBeTakenCopy", { name: file.name }),
        );
      await this.studio.refresh();
      this.open(answer.path);
    } catch (error) {
      this.studio.toasts.error(error);
    }
  }
}
