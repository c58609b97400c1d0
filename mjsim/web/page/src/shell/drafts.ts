/** Unsaved changes survive a crash of the page, the browser or the server: the server keeps them until they are saved. */

import { ApiError, type Draft, type DraftKept, type DraftText } from "../api";
import { askWith } from "../ui/dialog";
import { el } from "../ui/dom";
import { newestWins, throttled } from "../ui/signal";
import { draw, html, repeat, type View } from "../ui/view";
import { word } from "../words/words";
import type { Notices } from "./notices";
import type { TabLink } from "./tab";
import type { Studio } from "./view";

/** Changes are kept this long after the first of them [ms], also while the person types on. */
const PAUSE = 400;
/** What could not be kept is tried again after this long [ms]. */
const AGAIN = 3000;
/** A browser sends no more than this while a page is closed [bytes]. */
const MOST_AT_THE_END = 60_000;
/** The server is missed after this long [ms]: a restart takes a moment. */
const PATIENCE = 1500;

export class Drafts {
  private number = 0;
  /** What the server has of this tab; null for nothing. */
  private kept: string | null = null;
  /** The draft that the text goes on from, until the server has put this tab's in its place. */
  private restored: string | undefined;
  /** Drafts of closed tabs that the person has seen and left where they are. */
  private readonly seen = new Set<string>();
  /** Drafts of other tabs that the person has been told of. */
  private readonly known = new Set<string>();
  private others: Draft[] = [];
  private ready = false;
  private readonly keep = newestWins<void>(() => this.keepNow());
  private readonly keepSoon = throttled(() => this.keep(), PAUSE);
  /** Why changes were not kept the last time; '' when they were. */
  private reason = "";
  private timer = 0;
  /** Whether the server has not answered for a while. */
  private away = false;

  constructor(
    private readonly studio: Studio,
    private readonly link: TabLink,
    private readonly notices: Notices,
    private readonly mayLeave: () => Promise<boolean>,
  ) {
    const { document: world } = studio;
    world.stateChanged.on(() => {
      this.keepSoon();
      if (!world.isChanged) this.keepSoon.now();
    });
    world.opened.on(() => this.note());
    world.stateChanged.on(() => this.noteAway());
    link.drafts.on((drafts) => {
      this.others = drafts;
      this.note();
    });
    link.stateChanged.on(() => this.noteState());
    document.addEventListener("visibilitychange", () => document.hidden && this.keepSoon.now());
    // While the browser asks whether to leave, nothing else is done.
    window.addEventListener("beforeunload", () => this.keepSoon.now());
    window.addEventListener("pagehide", () => this.keepLast());
  }

  /** Offer what was not saved when pages of this folder were closed, that of the world that is open first. */
  async offerFirst(): Promise<void> {
    const { path } = this.studio.document;
    const own = ({ path: other, fresh }: Draft): number => Number(other === path && !fresh);
    const drafts = await this.left();
    await this.offer(drafts.sort((one, other) => own(other) - own(one)));
    this.ready = true;
    this.note();
  }

  /** Offer what was not saved of the world that is open. */
  async offerOwn(): Promise<void> {
    await this.offer((await this.left()).filter((draft) => this.isOwn(draft)));
  }

  /** Drafts of tabs that are closed, the newest first. */
  async left(): Promise<Draft[]> {
    try {
      const { drafts } = await this.studio.api.drafts();
      return drafts.filter(({ open, tab }) => !open && tab !== this.link.id);
    } catch (error) {
      this.studio.toasts.error(error);
      return [];
    }
  }

  /** Open what a draft was made from, unless it is open, and put the draft over it as one step that can be undone. */
  async restore({ id }: Draft): Promise<boolean> {
    const { api, document: world, toasts } = this.studio;
    try {
      const draft = await api.readDraft(id);
      if (draft.fresh || draft.path !== world.path) {
        if (!(await this.mayLeave())) return false;
        await this.begin(draft);
      }
      // What was made from other content than there is on disk now is not saved over it unasked.
      if (world.stamp !== null && draft.stamp !== null) world.stamp = draft.stamp;
      this.restored = id;
      // Kept at once: the page may be closed while the text is read. What is saved meanwhile is forgotten after that.
      await Promise.all([world.restore(draft.text, draft.past), this.keep()]);
      // What is on disk as it is was not kept, so it took the place of nothing.
      if (this.restored === id && !world.isChanged) {
        this.restored = undefined;
        await api.dropDraft(id);
      }
      return true;
    } catch (error) {
      toasts.error(error); // the draft stays for another time
      return false;
    }
  }

  private async discard({ id }: Draft): Promise<void> {
    await this.studio.api.dropDraft(id).catch((error) => this.studio.toasts.error(error));
  }

  /** What was never saved, or is no longer there, begins with an empty room under its name. */
  private async begin({ path, there }: DraftText): Promise<void> {
    const { api, document: world } = this.studio;
    if (there) world.take(await api.open(path));
    else world.take({ ...(await api.create()), path }, true);
  }

  private async offer(drafts: Draft[]): Promise<void> {
    if (drafts.length === 0) return;
    for (const { id } of drafts) this.seen.add(id);
    const chosen = await askWith<Draft>(word("shell.unsavedChanges"), (answer) => [
      el("p", { class: "hint" }, word("shell.theseChangesWereNot")),
      this.list(drafts, answer),
    ]);
    if (chosen) await this.restore(chosen);
  }

  /** A list of drafts, each to be restored or discarded; `answer` gets null when all are discarded. */
  list(drafts: Draft[], answer: (chosen: Draft | null) => void): HTMLElement {
    const list = el("ul", { class: "drafts" });
    const show = (left: Draft[]): void => {
      const drop = async (draft: Draft): Promise<void> => {
        show(left.filter((each) => each !== draft));
        await this.discard(draft);
        if (!list.firstElementChild) answer(null);
      };
      const row = (draft: Draft): View =>
        html`<li><span><b>${named(draft)}</b><span class="hint">${spoken(draft.when)}</span></span>
          <button type="button" class="danger" @click=${() => drop(draft)}>${word("shell.discard")}</button>
          <button type="button" class=${draft === drafts[0] ? "primary" : ""} ?autofocus=${draft === drafts[0]}
            @click=${() => answer(draft)}>${word("shell.restore")}</button></li>`;
      const rows = repeat(left, ({ id }) => id, row);
      draw(list, rows);
    };
    show(drafts);
    return list;
  }

  /** Tell of the drafts that others have of the world that is open, or left behind. */
  private note(): void {
    const own = this.others.filter((draft) => this.isOwn(draft));
    const { path } = this.studio.document;
    const open = own.find(({ open, id }) => open && !this.known.has(id));
    if (open) this.notices.set("tab", word("shell.anotherTabHasUnsaved", { path }), [], () => this.known.add(open.id));
    else this.notices.clear("tab");
    const left = this.ready ? own.find(({ open, id }) => !open && !this.seen.has(id)) : undefined;
    if (left) this.noteLeft(left);
    else this.notices.clear("left");
  }

  private noteLeft(draft: Draft): void {
    const done = (): void => {
      this.seen.add(draft.id);
      this.note();
    };
    const text = word("shell.aClosedTabLeft", { path: draft.path, when: spoken(draft.when) });
    const restore = (): void => void this.restore(draft).then((restored) => restored && done());
    const title = word("shell.youCanUndoThis");
    this.notices.set(
      "left",
      text,
      [
        { text: word("shell.discard"), kind: "danger", act: () => void this.discard(draft).then(done) },
        { text: word("shell.restore"), title, kind: "primary", act: restore },
      ],
      done,
    );
  }

  private isOwn(draft: Draft): boolean {
    return !draft.fresh && draft.path === this.studio.document.path;
  }

  /** When the server is back, or another one is there, it is told what there is to be kept. */
  private noteState(): void {
    window.clearTimeout(this.timer);
    const turn = (): void => {
      this.away = !this.link.isOpen;
      this.noteAway();
    };
    if (!this.link.isOpen) {
      this.timer = window.setTimeout(turn, PATIENCE);
      return;
    }
    turn();
    this.kept = null;
    this.keepSoon();
  }

  private noteAway(): void {
    if (!this.away || !this.studio.document.isChanged) return this.notices.clear("away");
    const text = word("shell.theStudioDoesNot");
    this.notices.set("away", text, [{ text: word("shell.download"), act: () => this.download() }]);
  }

  private download(): void {
    const { document: world } = this.studio;
    const address = URL.createObjectURL(new Blob([world.text], { type: "text/yaml" }));
    el("a", { href: address, download: (world.path || "world.yaml").replace(/^shipped:|^.*\//g, "") }).click();
    window.setTimeout(() => URL.revokeObjectURL(address), 1000);
  }

  /** What is to be kept of this tab; null for nothing. */
  private wanted(): string | null {
    const { document: world } = this.studio;
    if (!world.isChanged || world.path === null) return null;
    const { path, text, stamp, past } = world;
    const fresh = world.needsName && !path.startsWith("shipped:");
    return JSON.stringify({ path, fresh, stamp, text, past });
  }

  private async keepNow(): Promise<void> {
    const wanted = this.wanted();
    if (wanted === this.kept) return;
    const { api } = this.studio;
    const { restored } = this;
    const order = { tab: this.link.id, number: ++this.number };
    try {
      if (wanted === null) await api.forgetDraft(order);
      else await api.keepDraft({ ...order, ...(JSON.parse(wanted) as DraftKept), restored });
      if (wanted !== null && this.restored === restored) this.restored = undefined;
      this.kept = wanted;
      this.noteUnkept("");
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      if (error.status) this.noteUnkept(error.message);
      window.setTimeout(() => this.keepSoon(), AGAIN);
    }
  }

  /** Say why changes are not kept, once for each reason; '' when they are. */
  private noteUnkept(reason: string): void {
    if (reason === "") this.notices.clear("unkept");
    else if (reason !== this.reason) this.notices.set("unkept", reason, []);
    this.reason = reason;
  }

  /** The page is being closed: what has not been kept yet goes along. */
  private keepLast(): void {
    const wanted = this.wanted();
    if (wanted === this.kept) return;
    const order = { tab: this.link.id, number: ++this.number };
    const said = JSON.stringify(
      wanted === null ? order : { ...order, ...(JSON.parse(wanted) as DraftKept), restored: this.restored },
    );
    const body = new Blob([said], { type: "application/json" });
    const address = `/api/draft/${wanted === null ? "forget" : "keep"}`;
    void fetch(address, { method: "POST", body, keepalive: body.size < MOST_AT_THE_END }).catch(() => undefined);
  }
}

function named({ path, fresh }: Draft): string {
  return fresh ? word("shell.aNewWorld", { path }) : path.replace(/^shipped:/, "");
}

function spoken(when: number): string {
  return new Date(when * 1000).toLocaleString([], { dateStyle: "medium", timeStyle: "short" });
}
