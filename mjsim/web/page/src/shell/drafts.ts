/** Work that was not saved outlives a reload or a crash: it is kept in this browser until it is saved or dropped. */

import { ApiError } from "../api";
import { el } from "../dom";
import { debounced } from "../signal";
import { ask } from "./dialog";
import type { Studio } from "./view";

const KEY = "mjsim.draft:";
/** A change is kept after so long a pause [ms]. */
const PAUSE = 400;
/** Longer texts are not kept [letters], and no more drafts than so many. */
const LONGEST = 500_000;
const MOST = 6;

interface Draft {
  folder: string;
  path: string;
  /** Never saved: the path is only what it was to be called. */
  fresh: boolean;
  text: string;
  /** When it was kept [ms since 1970]. */
  when: number;
}

export class Drafts {
  /** Under what this page keeps the draft of the world that is open. */
  private key: string | null = null;
  private readonly keepSoon = debounced(() => this.keep(), PAUSE);

  constructor(private readonly studio: Studio) {
    studio.document.stateChanged.on(() => (studio.document.isChanged ? this.keepSoon() : this.forget()));
    window.addEventListener("pagehide", () => this.keepSoon.now());
  }

  /** Offer what was not saved when the page was last left: of the world that is open, else the newest. */
  async offerFirst(): Promise<void> {
    const mine = all().filter(([, draft]) => draft.folder === this.studio.folder.folder);
    const { path } = this.studio.document;
    const found = mine.find(([, draft]) => draft.path === path && !draft.fresh) ?? mine[0];
    if (found) await this.offer(...found);
  }

  /** Offer the draft of the world that is open, if there is one. */
  async offerOwn(): Promise<void> {
    const { folder, document } = this.studio;
    const key = keyOf({ folder: folder.folder, path: document.path ?? "", fresh: false });
    const draft = read(key);
    if (draft) await this.offer(key, draft);
  }

  private async offer(key: string, draft: Draft): Promise<void> {
    const { document, toasts } = this.studio;
    if (!draft.fresh && draft.path === document.path && draft.text === document.text) return remove(key);
    const what = `What was changed in ${draft.fresh ? "a new world" : draft.path} was not saved; it is of ${spoken(draft.when)}.`;
    const hint = "Taken up, it can be undone, and is saved when you save it.";
    const answer = await ask(
      "Unsaved work",
      [el("p", {}, what), el("p", { class: "hint" }, hint)],
      [
        { text: "Drop it", value: false, kind: "danger" },
        { text: "Take it up", value: true, kind: "primary" },
      ],
    );
    if (answer === null) return;
    try {
      if (answer) await this.takeUp(draft);
      if (key !== this.key) remove(key);
    } catch (error) {
      toasts.error(error); // the draft stays for another time
    }
  }

  /** Open what it began with, then put the draft over it as one step. */
  private async takeUp(draft: Draft): Promise<void> {
    const { document } = this.studio;
    if (draft.fresh || draft.path !== document.path) await this.begin(draft);
    await document.replace(draft.text);
    this.keepSoon.now();
  }

  /** What was never saved, or is there no more, begins with an empty room under its name. */
  private async begin({ path, fresh }: Draft): Promise<void> {
    const { api, document } = this.studio;
    try {
      if (!fresh) return document.take(await api.open(path));
    } catch (error) {
      if (!(error instanceof ApiError) || error.status !== 404) throw error;
    }
    document.take({ ...(await api.create()), path }, true);
  }

  private keep(): void {
    const { document, folder } = this.studio;
    if (!document.isChanged || document.path === null || document.text.length > LONGEST) return this.forget();
    const { path, text } = document;
    const fresh = document.needsName && !path.startsWith("shipped:");
    const draft: Draft = { folder: folder.folder, path, fresh, text, when: Date.now() };
    const key = keyOf(draft);
    if (key !== this.key) this.forget();
    this.key = key;
    write(key, draft);
    for (const [old] of all().slice(MOST)) remove(old);
  }

  private forget(): void {
    if (this.key !== null) remove(this.key);
    this.key = null;
  }
}

/** One for each world, and one for a new one. */
function keyOf({ folder, path, fresh }: Pick<Draft, "folder" | "path" | "fresh">): string {
  return `${KEY}${folder}\n${fresh ? "" : path}`;
}

/** All drafts of this browser, the newest first. */
function all(): [string, Draft][] {
  return keys()
    .flatMap((key): [string, Draft][] => {
      const draft = read(key);
      return draft ? [[key, draft]] : [];
    })
    .sort(([, one], [, other]) => other.when - one.when);
}

/** A browser may forbid to keep things, or have no room left: then there are no drafts. */
function keys(): string[] {
  try {
    return Object.keys(localStorage).filter((key) => key.startsWith(KEY));
  } catch {
    return [];
  }
}

function read(key: string): Draft | null {
  try {
    const draft = JSON.parse(localStorage.getItem(key) ?? "null") as Partial<Draft> | null;
    const { folder, path, text, fresh, when } = draft ?? {};
    const whole = [folder, path, text].every((part) => typeof part === "string") && typeof when === "number" && typeof fresh === "boolean";
    return whole ? (draft as Draft) : null;
  } catch {
    return null;
  }
}

function write(key: string, draft: Draft): void {
  try {
    localStorage.setItem(key, JSON.stringify(draft));
  } catch {
    remove(key);
  }
}

function remove(key: string): void {
  try {
    localStorage.removeItem(key);
  } catch {
    // Then there is none.
  }
}

function spoken(when: number): string {
  return new Date(when).toLocaleString([], { dateStyle: "medium", timeStyle: "short" });
}
