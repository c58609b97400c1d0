/** The recordings of the folder, and a place to drop another. */

import { ApiError } from "../api";
import type { Studio } from "../shell/view";
import { el } from "../ui/dom";
import { theme, themeChanged } from "../ui/theme";
import { draw, html, live, nothing, repeat, type View, withValue } from "../ui/view";
import { heard, said, word } from "../words/words";
import { factsOf, isFound, newestFirst, type RecordingCard } from "./facts";
import { recordings } from "./recording";

/** Fewer recordings are found without a search. */
const FEW = 6;

export class Library {
  readonly element = el("div", { class: "run-library" });
  /** Paths that are ticked. */
  private ticked = new Set<string>();
  /** What recordings are of, the newest first. */
  private cards: RecordingCard[] = [];
  /** What is searched for. */
  private wish = "";
  /** Whether what is compared is being read. */
  private isReading = false;

  constructor(
    private readonly studio: Studio,
    /** Path of the recording that is open. */
    private readonly current: () => string | undefined,
    private readonly open: (path: string) => void,
    private readonly compare: (paths: string[]) => Promise<void>,
  ) {
    themeChanged.on(() => this.draw());
  }

  /** Ask what the recordings are of. */
  async load(): Promise<void> {
    this.cards = await recordings.cards();
  }

  draw(): void {
    const { recordings, sweeps } = this.studio.folder;
    for (const path of this.ticked) if (!recordings.includes(path) && !sweeps.includes(path)) this.ticked.delete(path);
    const newest = newestFirst(this.cards, recordings);
    const wish = recordings.length < FEW ? "" : this.wish;
    const search = withValue((wish) => {
      this.wish = wish;
      this.draw();
    });
    const pathOf = (path: string): string => path;
    const sweep = (path: string): View => html`<li><label>${this.box(path)}${path}</label></li>`;
    const found = word("review.findARecording");
    const view = html`<input type="search" ?hidden=${recordings.length < FEW} placeholder=${found} aria-label=${found} @input=${search}>
        <ul>${repeat(newest, pathOf, (path) => this.entry(path, wish))}</ul>
        <div>${
          sweeps.length ? html`<h2>${word("review.sweeps")}</h2><ul>${repeat(sweeps, pathOf, sweep)}</ul>` : nothing
        }</div>
        <p class="hint">${word(recordings.length ? "review.orDropAnMcapFile" : "review.thereIsNoRecordingIn")}</p>
        ${this.foot(recordings, sweeps)}`;
    draw(this.element, view);
  }

  /** Two runs can be compared, and a sweep alone. */
  private foot(recordings: string[], sweeps: string[]): View {
    const paths = [...this.ticked];
    const enough = paths.length > 1 || paths.some((path) => sweeps.includes(path));
    const all = recordings.every((path) => this.ticked.has(path));
    const ready = enough ? word("review.compareChosen", { paths: paths.length }) : word("review.compareTickTwoOrMore");
    return html`<div class="run-compare" ?hidden=${recordings.length + sweeps.length === 0}>
      <button type="button" class="quiet run-small" @click=${() => this.tick(all ? [] : recordings)}
        >${word(all ? "review.tickNone" : "review.tickAll")}</button>
      <button type="button" class="primary" ?disabled=${!enough || this.isReading} @click=${() => this.begin()}
        >${this.isReading ? word("review.reading") : ready}</button></div>`;
  }

  /** Focus the button that starts a comparison. */
  focus(): void {
    this.element.querySelector<HTMLElement>(".run-compare .primary")?.focus({ preventScroll: true });
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

  private box(path: string): View {
    const tick = ({ target }: Event): void => {
      if ((target as HTMLInputElement).checked) this.ticked.add(path);
      else this.ticked.delete(path);
      this.draw();
    };
    return html`<input type="checkbox" aria-label=${word("review.compare2", { path })} @change=${tick}
      .checked=${live(this.ticked.has(path))}>`;
  }

  /** Tick these, and no others. */
  private tick(paths: string[]): void {
    this.ticked = new Set(paths);
    this.draw();
  }

  /** Compare what is ticked; many recordings take a while to read. */
  private async begin(): Promise<void> {
    this.isReading = true;
    this.draw();
    await this.compare([...this.ticked]);
    this.isReading = false;
    this.draw();
  }

  /** A recording; hidden unless it is what is searched for. */
  private entry(path: string, wish: string): View {
    const cut = path.lastIndexOf("/") + 1;
    const card = this.cards.find((each) => each.path === path);
    const facts = card ? factsOf(card) : [];
    const picture = card?.world && html`<img src=${recordings.plan(path, theme())} alt="" loading="lazy">`;
    const told = facts.map((fact) => html`<span class="hint">${fact}</span>`);
    return html`<li ?hidden=${!isFound(wish, path, facts)}>${this.box(path)}<button type="button"
      class="quiet" title=${path} data-path=${path} aria-current=${path === this.current() ? "true" : nothing}
      @click=${() => this.open(path)}>${picture}<b>${path.slice(cut)}</b><span class="hint">${path.slice(0, cut)}</span
      >${card ? html`<span class="run-facts">${told}</span>` : nothing}</button></li>`;
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
