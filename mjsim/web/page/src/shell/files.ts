/** Opening, making and saving worlds; a file that changed on disk is never overwritten without asking. */

import { ApiError, type Draft, type Opened } from "../api";
import { ask, askWith } from "../ui/dialog";
import { el } from "../ui/dom";
import { draw, html, nothing, type View, withValue } from "../ui/view";
import { meaningOf, word } from "../words/words";
import { Drafts } from "./drafts";
import type { Notices } from "./notices";
import type { TabLink } from "./tab";
import type { Studio } from "./view";

type Wanted = { open: string } | { make: string | undefined } | { restore: Draft };

export class Files {
  readonly drafts: Drafts;
  /** Whether a save is under way: what the disk has then is not news. */
  isSaving = false;
  /** How many worlds have been asked for. */
  private turn = 0;
  /** The world that was asked for last; false: it was not taken up. */
  coming: Promise<boolean> = Promise.resolve(false);

  constructor(
    private readonly studio: Studio,
    link: TabLink,
    notices: Notices,
  ) {
    this.drafts = new Drafts(studio, link, notices, () => this.mayLeave());
  }

  /** Let the person choose a world of the folder, or one that comes with mjsim. */
  async ask(): Promise<void> {
    await this.studio.refresh().catch((error) => this.studio.toasts.error(error));
    const drafts = await this.drafts.left();
    const wanted = await askWith<Wanted>(word("shell.openAWorld"), (answer) => this.worldList(drafts, answer));
    if (wanted) await this.take(wanted);
  }

  /** Let the person choose what a new world begins with. */
  async askNew(): Promise<void> {
    const wanted = await askWith<Wanted>(word("shell.newWorld"), (answer) => [
      html`<p class="hint">${word("shell.nothingIsWrittenTo")}</p><div class="cards">${this.templates(answer)}</div>`,
    ]);
    if (wanted) await this.take(wanted);
  }

  /** Open a world; the tab stays as it is. False: it was not taken up. */
  openFirst(path: string): Promise<boolean> {
    return this.load(() => this.studio.api.open(path), false);
  }

  /** Open a world and show it. */
  async openPath(path: string): Promise<void> {
    if (!(await this.loadToEdit(() => this.studio.api.open(path), false))) return;
    await this.drafts.offerOwn();
  }

  async create(template?: string): Promise<void> {
    await this.loadToEdit(() => this.studio.api.create(template), true);
  }

  /** Save where it came from; a new one is asked for its name. */
  async save(): Promise<void> {
    const { document: world } = this.studio;
    if (!world.isOpen) return;
    await world.settled();
    if (world.needsName) return this.saveAs();
    await this.write(world.path ?? "", world.stamp, false);
  }

  async saveAs(): Promise<void> {
    const { document: world } = this.studio;
    await world.settled();
    const field = el("input", {
      value: this.freshName(),
      spellcheck: false,
      required: true,
      "aria-label": word("shell.file"),
    });
    const note = el("p", { class: "hint" }, word("shell.in", { folder: this.studio.folder.folder }));
    const answer = await ask(
      word("shell.saveAs"),
      [note, field],
      [
        { text: word("shell.cancel"), value: false },
        { text: word("shell.save"), value: true, kind: "primary" },
      ],
    );
    const name = field.value.trim();
    if (!answer || !name) return;
    await this.write(/\.ya?ml$/.test(name) ? name : `${name}.yaml`, null, false);
  }

  private async take(wanted: Wanted): Promise<void> {
    if ("restore" in wanted) await this.drafts.restore(wanted.restore);
    else if ("open" in wanted) await this.openPath(wanted.open);
    else await this.create(wanted.make);
  }

  /** Take up a world and show it, unless the person has gone to a view meanwhile; in Run, one with a file stays there. */
  private async loadToEdit(get: () => Promise<Opened>, isNew: boolean): Promise<boolean> {
    const { visits, view } = this.studio;
    const taken = await this.load(get, isNew);
    if (taken && this.studio.visits === visits && (isNew || view !== "run")) this.studio.show("edit");
    return taken;
  }

  private load(get: () => Promise<Opened>, isNew: boolean): Promise<boolean> {
    this.coming = this.loadNow(get, isNew);
    return this.coming;
  }

  /** Take up a world; false: the person would rather stay, or it cannot be read. */
  private async loadNow(get: () => Promise<Opened>, isNew: boolean): Promise<boolean> {
    if (!(await this.mayLeave())) return false;
    const { document: world, toasts } = this.studio;
    const { text } = world;
    const turn = ++this.turn;
    try {
      const opened = await get();
      // What was asked for last is shown, whichever comes first; and what was changed meanwhile is not lost.
      if (turn !== this.turn || (world.text !== text && !(await this.mayLeave()))) return false;
      world.take(opened, isNew);
      return true;
    } catch (error) {
      if (turn === this.turn) toasts.error(error);
      return false;
    }
  }

  /** Ask before changes would be lost. */
  private async mayLeave(): Promise<boolean> {
    const { document: world } = this.studio;
    await world.settled();
    if (!world.isChanged) return true;
    const { path } = world;
    const text = path ? word("shell.changesNotSaved", { path }) : word("shell.newWorldNotSaved");
    const answer = await ask<"stay" | "save" | "drop">(
      word("shell.saveFirst"),
      [el("p", {}, text)],
      [
        { text: word("shell.cancel"), value: "stay" },
        { text: word("shell.dropTheChanges"), value: "drop", kind: "danger" },
        { text: word("shell.save"), value: "save", kind: "primary" },
      ],
    );
    if (answer === "save") await this.save();
    return answer === "drop" || (answer === "save" && !world.isChanged);
  }

  /** Save the text beside its file under a name that is free, and go on with that one. */
  async keepBoth(): Promise<void> {
    const { document: world, toasts } = this.studio;
    const base = (world.path ?? "world.yaml").replace(/\.ya?ml$/, "");
    for (let number = 2; number < 100; number++) {
      const path = `${base}-${number}.yaml`;
      try {
        return await this.saveTo(path, null, false);
      } catch (error) {
        if (!(error instanceof ApiError) || typeof error.data["stamp"] !== "string") return toasts.error(error);
      }
    }
  }

  /** Put the content of the file in place of the text, as a step that can be undone. */
  async reload(): Promise<void> {
    const { api, document: world, toasts } = this.studio;
    const { path } = world;
    try {
      await world.settled();
      const opened = await api.open(path ?? "");
      if (world.path === path) world.reload(opened);
    } catch (error) {
      toasts.error(error);
    }
  }

  private async write(path: string, stamp: string | null, overwrite: boolean): Promise<void> {
    try {
      await this.saveTo(path, stamp, overwrite);
    } catch (error) {
      const isOther = error instanceof ApiError && typeof error.data["stamp"] === "string";
      if (isOther && !overwrite) await this.conflict(path, error);
      else this.studio.toasts.error(error);
    }
  }

  private async saveTo(path: string, stamp: string | null, overwrite: boolean): Promise<void> {
    const { document: world, toasts, api } = this.studio;
    const { text } = world;
    const moved = path !== world.path;
    this.isSaving = true;
    try {
      const saved = await api.save(path, text, stamp, overwrite);
      world.noteSaved(path, saved.stamp, text);
    } finally {
      this.isSaving = false;
    }
    toasts.done(word("shell.saved", { path }));
    await this.studio.refresh().catch((error) => toasts.error(error));
    if (moved) await world.read(); // what stands beside the file is looked for from its new place
  }

  /** The file is not as it was when it was read: whose text shall stand? */
  private async conflict(path: string, error: ApiError): Promise<void> {
    const same = path === this.studio.document.path;
    const body = [el("p", {}, error.message), el("p", { class: "hint" }, word("shell.yourTextIsKept"))];
    const title = same ? word("shell.isNotAsIt", { path }) : word("shell.isThereAlready", { path });
    const answer = await ask<"mine" | "theirs" | "name">(title, body, [
      { text: word("shell.overwriteIt"), value: "mine", kind: "danger" },
      ...(same ? [{ text: word("shell.loadTheOneOn"), value: "theirs" as const }] : []),
      { text: word("shell.saveUnderAnotherName"), value: "name", kind: "primary" },
    ]);
    if (answer === "mine") {
      const stamp = typeof error.data["stamp"] === "string" ? error.data["stamp"] : null;
      await this.write(path, stamp, true);
    } else if (answer === "theirs") await this.reload();
    else if (answer === "name") await this.saveAs();
  }

  private freshName(): string {
    const { document: world, folder } = this.studio;
    const base = (world.path || world.parsed.name || "world").replace(/^shipped:/, "").replace(/\.ya?ml$/, "");
    const names = [base, ...Array.from({ length: 99 }, (_, index) => `${base}-${index + 2}`)];
    return `${names.find((name) => !folder.worlds.includes(`${name}.yaml`)) ?? base}.yaml`;
  }

  private worldList(drafts: Draft[], answer: (wanted: Wanted) => void): View {
    const list = el("div", {});
    const restore = (draft: Draft | null): unknown => draft && answer({ restore: draft });
    const unsaved = drafts.length
      ? [heading(word("shell.unsavedChanges")), this.drafts.list(drafts, restore)]
      : nothing;
    const show = (wish: string): void => draw(list, [unsaved, this.worlds(answer, wish)]);
    const take = (event: KeyboardEvent): void => {
      // While an input method is composing, Enter belongs to it.
      if (event.key !== "Enter") return;
      event.preventDefault();
      const shown = [...list.querySelectorAll<HTMLElement>(".card:not([hidden])")];
      const wanted = (event.target as HTMLInputElement).value.trim();
      (shown.find((card) => card.querySelector("b")?.textContent === wanted) ?? shown[0])?.click();
    };
    show("");
    const find = word("shell.findAWorld");
    return html`<input type="search" class="search" placeholder=${find} aria-label=${find} autofocus @input=${withValue(show)}
      @keydown=${take}>${list}`;
  }

  /** Worlds and templates; those without the words that are searched for are hidden. */
  private worlds(answer: (wanted: Wanted) => void, wish: string): View {
    const { folder } = this.studio;
    const cards = (worlds: string[], prefix: string): View =>
      worlds.map((world) => {
        const about = folder.abouts[prefix + world] ?? "";
        return card(called(world), about, () => answer({ open: prefix + world }), { wish, label: world });
      });
    const none = html`<p class="hint">${word("shell.noWorldFileIn")}</p>`;
    return html`${heading(folder.folder)}
      ${folder.worlds.length ? html`<div class="cards">${cards(folder.worlds, "")}</div>` : none}
      ${heading(word("shell.comeWithMjsimSaved"))}<div class="cards">${cards(folder.shipped.worlds, "shipped:")}</div>
      ${heading(word("shell.new"))}<div class="cards">${this.templates(answer, wish)}</div>`;
  }

  private templates(answer: (wanted: Wanted) => void, wish = ""): View {
    const { templates, about } = this.studio.folder.shipped;
    const make = (name?: string) => (): void => answer({ make: name });
    return [
      card(word("shell.emptyRoom"), word("shell.nothingButAFloor"), make(), { wish, isFirst: true }),
      ...templates.map((name) => card(name, meaningOf(about[name] ?? ""), make(name), { wish })),
    ];
  }
}

function heading(text: string): View {
  return html`<p class="list-title">${text}</p>`;
}

interface Offered {
  /** What is searched for. */
  wish: string;
  /** The name for those who do not see it. */
  label?: string;
  isFirst?: boolean;
}

function card(title: View, about: string, press: () => void, { wish, label, isFirst = false }: Offered): View {
  const isShown = `${label ?? title}${about}`.toLowerCase().includes(wish.trim().toLowerCase());
  return html`<button class="card" aria-label=${label ?? nothing} aria-description=${(label && about) || nothing}
    ?autofocus=${isFirst} ?hidden=${!isShown} @click=${press}><b>${title}</b>${
      about ? html`<span class="hint">${about}</span>` : nothing
    }</button>`;
}

/** A name that is broken between folders, if it must be. */
function called(path: string): View {
  return path.split("/").map((part, k) => (k ? html`/<wbr>${part}` : part));
}
