/** The frame of the page: tabs, the world's name, open and save, the switch of colours, and the keys for them. */

import { api, type Folder } from "../api";
import { makeEditView } from "../edit/edit";
import { tellUnhandled } from "../failures";
import { makeReviewView } from "../review/index";
import { makeRunView } from "../run/index";
import { el, isCommand, isHalfTyped, isPress, isSign, isTyping } from "../ui/dom";
import { iconButton, sign } from "../ui/icons";
import { switchTheme, theme, themeChanged } from "../ui/theme";
import { type View as Drawn, draw, html, nothing } from "../ui/view";
import { word } from "../words/words";
import { type Place, placeAt } from "./address";
import { Disk } from "./disk";
import { WorldDocument } from "./document";
import { Files } from "./files";
import { askHelp } from "./help";
import { askInvite } from "./invite";
import { languageButton } from "./language";
import { Notices } from "./notices";
import { stepsButton } from "./steps";
import { TabLink } from "./tab";
import { Toasts } from "./toasts";
import { takeTour } from "./tour";
import { askTrust, type RunCode } from "./trust";
import type { Moment, Studio, View, ViewName } from "./view";
import { Way } from "./way";

const MAKERS: Record<ViewName, (studio: Studio) => View> = {
  edit: makeEditView,
  run: makeRunView,
  review: makeReviewView,
};
const TITLES: Record<ViewName, string> = {
  edit: word("shell.edit"),
  run: word("shell.run"),
  review: word("shell.review"),
};
const NAMES = Object.keys(TITLES) as ViewName[];

export class Shell implements Studio {
  readonly api = api;
  readonly document = new WorldDocument(api);
  readonly toasts = new Toasts();
  recording: Moment | null = null;
  private looked: Moment | null = null;
  private readonly way = new Way(
    () => this.where(),
    (place) => this.go(place),
  );
  private readonly notices = new Notices();
  private files!: Files;
  private readonly views = new Map<ViewName, View>();
  private readonly place = el("main", { class: "views" });
  private readonly bar = el("header", { class: "bar" });
  view: ViewName | null = null;
  visits = 0;

  constructor(
    root: HTMLElement,
    public folder: Folder,
  ) {
    const live = folder.mode === "live";
    if (!live) this.link();
    root.replaceChildren(this.bar, this.notices.element, this.place, this.toasts.element);
    root.removeAttribute("aria-busy");
    const note = (): void => this.note();
    this.document.stateChanged.on(note);
    this.document.opened.on(note);
    themeChanged.on(() => this.draw());
    this.document.textChanged.on((origin) => origin !== "draft" && this.toasts.worked());
    this.document.failed.on((error) => this.toasts.error(error));
    tellUnhandled(window, (error) => this.toasts.error(error));
    window.addEventListener("keydown", (event) => this.key(event));
    window.addEventListener("beforeunload", (event) => this.document.isChanged && event.preventDefault());
    this.note();
    const place = placeAt(location.hash);
    this.showPlace(live ? { ...place, view: "run" } : place);
    if (!live) void this.way.follow(() => this.begin(place.world, folder.world));
  }

  private link(): void {
    const link = new TabLink();
    this.files = new Files(this, link, this.notices);
    new Disk(this, link, this.files, this.notices);
  }

  /** Open the world of the address, or else the one that the command named, and offer what was not saved before. */
  private async begin(...worlds: (string | null)[]): Promise<void> {
    for (const world of worlds) if (world && (await this.files.openFirst(world))) break;
    await this.files.drafts.offerFirst();
  }

  looksAt(moment: Moment | null): void {
    this.looked = moment;
    this.way.changed();
  }

  /** What the address is to say. */
  private where(): Place {
    const { path, hasFile } = this.document;
    const { path: recording = null, time = 0 } = (this.view === "review" && this.looked) || {};
    return { view: this.view ?? "edit", world: hasFile ? path : null, recording, time };
  }

  /** Show what an address says. */
  private async go(place: Place): Promise<void> {
    if (place.world && place.world !== this.document.path) await this.files.openFirst(place.world);
    this.showPlace(place);
  }

  private showPlace({ view, recording, time }: Place): void {
    const isThere = recording === this.looked?.path;
    this.show(NAMES.find((name) => name === view) ?? "edit", isThere ? undefined : (recording ?? undefined), time);
  }

  show(name: ViewName, recording?: string, time = 0): void {
    if (recording !== undefined) this.recording = this.looked = { path: recording, time };
    if (this.live && name !== "run") return;
    this.visits++;
    const again = this.view === name;
    if (this.view && !again) this.views.get(this.view)?.hidden();
    let view = this.views.get(name);
    if (!view) {
      view = MAKERS[name](this);
      view.element.id = `view-${name}`;
      this.views.set(name, view);
    }
    this.view = name;
    this.draw();
    this.place.replaceChildren(view.element);
    this.way.changed();
    if (!again || recording !== undefined) view.shown();
  }

  async settled(): Promise<void> {
    if (!this.live) await this.files.coming;
    await this.document.settled();
  }

  async refresh(): Promise<void> {
    this.folder = await api.folder();
  }

  askOpen(): Promise<void> {
    return this.files.ask();
  }

  askNew(): Promise<void> {
    return this.files.askNew();
  }

  askTrust(run?: RunCode): Promise<boolean> {
    return askTrust(this, run);
  }

  private get live(): boolean {
    return this.folder.mode === "live";
  }

  private draw(): void {
    const isDark = theme() === "dark";
    const colours = word(isDark ? "shell.lightColours" : "shell.darkColours");
    const invite = (): void => void askInvite(this.toasts);
    const view = html`<h1 class="brand">mjsim</h1>${this.live ? nothing : this.worldTools()}<span class="space"></span>
        ${this.live ? nothing : this.tabs()}<span class="space"></span>
        ${iconButton("share", word("shell.openInAnotherBrowser"), invite)}
        <span class="helping">${iconButton("help", word("shell.keysShortcut"), () => this.help())}</span>
        ${languageButton()}${iconButton(isDark ? "sun" : "moon", colours, switchTheme)}`;
    draw(this.bar, view);
  }

  /** What opens and saves worlds, and undoes. */
  private worldTools(): Drawn {
    const { document: world, files } = this;
    const unsaved = word("shell.notSavedYet");
    return html`<button class="quiet world" title=${word("shell.openAWorldCtrl")} @click=${() => files.ask()}
        ><span class="name">${world.isOpen ? this.called : word("shell.openAWorld")}</span><span class="dot" role="img"
        title=${unsaved} aria-label=${unsaved} ?hidden=${!world.isChanged}>•</span>${sign("down")}</button>
      ${iconButton("new", word("shell.newWorld"), () => void files.askNew())}
      ${iconButton("save", word("shell.saveCtrlS"), () => void files.save(), !world.isOpen)}<span class="divider"></span>
      ${iconButton("undo", word("shell.undoCtrlZ"), () => void world.undo(), !world.canUndo)}
      ${iconButton("redo", word("shell.redoCtrlShiftZ"), () => void world.redo(), !world.canRedo)}${stepsButton(world)}`;
  }

  private help(): void {
    void askHelp(this.live ? undefined : () => void takeTour(this));
  }

  private tabs(): Drawn {
    const tab = (name: ViewName, index: number): Drawn =>
      html`<button role="tab" title="${TITLES[name]} (Alt+${index + 1})" aria-controls="view-${name}"
        aria-selected=${name === this.view} tabindex=${name === this.view ? 0 : -1} @click=${() => this.show(name)}
        @keydown=${(event: KeyboardEvent) => this.tabKey(event, index)}>${TITLES[name]}</button>`;
    return html`<div class="tabs" role="tablist" aria-label=${word("shell.views")}>${NAMES.map(tab)}</div>`;
  }

  /** Arrows go through the tabs, as everywhere. */
  private tabKey(event: KeyboardEvent, index: number): void {
    const step = event.key === "ArrowRight" ? 1 : event.key === "ArrowLeft" ? -1 : 0;
    const next = NAMES[(index + step + NAMES.length) % NAMES.length];
    if (step === 0 || !next) return;
    event.stopPropagation();
    this.show(next);
    this.bar.querySelector<HTMLElement>("[aria-selected=true]")?.focus();
  }

  /** The name of the world that is open. */
  private get called(): string {
    return this.document.path?.replace(/^shipped:/, "") || word("shell.newWorld");
  }

  private note(): void {
    const { isOpen, isChanged } = this.document;
    this.draw();
    this.way.changed();
    document.title = isOpen ? `${isChanged ? "• " : ""}${this.called} – mjsim studio` : "mjsim studio";
  }

  private key(event: KeyboardEvent): void {
    if (document.querySelector("dialog[open]")) return;
    if (this.globalKey(event)) return event.preventDefault();
    const isText = isTyping(event.target) || isPress(event);
    if (!isText && !event.defaultPrevented && this.view && this.views.get(this.view)?.key?.(event))
      event.preventDefault();
  }

  private globalKey(event: KeyboardEvent): boolean {
    if (event.altKey && !isCommand(event) && !isSign(event) && /^Digit[123]$/.test(event.code) && !this.live) {
      this.show(NAMES[Number(event.code.slice(5)) - 1] ?? "edit");
      return true;
    }
    if (event.key === "?" && !isTyping(event.target)) return (this.help(), true);
    if (!isCommand(event) || event.altKey || this.live) return false;
    return this.commandKey(event);
  }

  private commandKey(event: KeyboardEvent): boolean {
    const key = event.key.toLowerCase();
    // A field of the panel has its own undo until it is left.
    const inField = isHalfTyped(event.target);
    if (key === "s") void (event.shiftKey ? this.files.saveAs() : this.files.save());
    else if (key === "o") void this.files.ask();
    else if (key === "z" && !inField) void (event.shiftKey ? this.document.redo() : this.document.undo());
    else if (key === "y" && !inField) void this.document.redo();
    else return false;
    return true;
  }
}
