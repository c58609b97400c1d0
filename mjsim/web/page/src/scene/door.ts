/** The way to the view in 3-D: its program is fetched when it is first opened. */

import type { Item, Point } from "../api";
import { ApiError } from "../api";
import { keyOf } from "../plan/plan";
import { el } from "../ui/dom";
import { newestWins, Signal } from "../ui/signal";
import { themeChanged } from "../ui/theme";
import { word } from "../words/words";
import type { Grip, Lead, Led, LooseThing, Pull, Put } from "./grip";
import type { SceneView } from "./scene";
import type { Thoughts } from "./thoughts";
import "./scene.css";

const PROGRAM = "/scene.js";

/** A view in 3-D that is there once it is opened, and asks for what it shows only while it is seen. */
export class Door {
  readonly element = el("div", { class: "scene-door", "data-view": "scene" });
  readonly chosen = new Signal<Item | null>();
  /** What is done by a handle. */
  readonly pulled = new Signal<Pull>();
  /** What is led somewhere by a handle. */
  readonly led = new Signal<Led>();
  /** From where to where the floor was dragged while goals are set [m]. */
  readonly aimed = new Signal<[from: Point, to: Point]>();
  private aims = false;
  /** What is put elsewhere. */
  readonly put = new Signal<Put>();
  /** Told with its pictures a second when those are too few. */
  readonly slow = new Signal<number>();
  /** Told when the scene is there, and when it no longer is. */
  readonly ready = new Signal();
  private view: SceneView | null = null;
  private open = false;
  private loaded: unknown = null;
  /** The scene that is on its way, or there. */
  private asked: unknown = null;
  /** The world that it is of. */
  private world = "";
  /** The code of a world that the person did not allow. */
  private declined = "";
  private order: (() => Promise<ArrayBuffer>) | null = null;
  private shown: [Item[], Item[]] = [[], []];
  private thought: Thoughts | null = null;
  private held: [Grip | null, string] = [null, ""];
  private readonly wanted: (key: unknown) => void;
  private readonly moved: (order: () => Promise<ArrayBuffer>) => void;

  constructor(
    /** Gives the scene as glTF. */
    private readonly scene: () => Promise<ArrayBuffer>,
    /** Lets the person allow the world's own code; true: it may run. */
    private readonly allow: () => Promise<boolean> = () => Promise.resolve(false),
  ) {
    // The program that is fetched later has no part in the page's own signals.
    themeChanged.on(() => this.view?.recolor());
    this.wanted = newestWins((key: unknown) => this.load(key));
    this.moved = newestWins((order: () => Promise<ArrayBuffer>) => this.move(order));
  }

  get isOpen(): boolean {
    return this.open;
  }

  /** Whether the scene that is wanted is seen: places of its bodies are of use. */
  get isReady(): boolean {
    return this.open && this.loaded !== null;
  }

  /** Open or shut it; `key` tells one scene from another. */
  set(open: boolean, key: unknown): void {
    this.open = open;
    if (open) this.view?.think(this.thought);
    if (key !== null) this.want(key);
    this.ready.emit();
  }

  /** The scene of this key is to be seen; it is asked for unless it is there. All of another world is shown at first. */
  want(key: unknown, world = this.world): void {
    // Places are those of the scene before.
    if (this.asked !== key) this.order = null;
    this.asked = key;
    this.world = world;
    if (!this.open) return;
    if (this.loaded === key && this.view) this.view.shown();
    else {
      this.loaded = null;
      this.ready.emit();
      this.element.dataset["scene"] = "on its way";
      this.wanted(key);
    }
  }

  /** What can be picked, and what of it is selected. */
  show(items: Item[], selected: Item[]): void {
    this.shown = [items, selected];
    this.view?.show(items, selected);
  }

  /** By which handles what is selected is held; what is said about it. */
  hold(grip: Grip | null, said: string): void {
    this.held = [grip, said];
    this.view?.hold(grip, said);
  }

  /** Whether presses on the floor are goals. */
  aim(on: boolean): void {
    this.aims = on;
    this.view?.aim.set(on);
  }

  /** Which tools and hands can be led, and which things dragged; false while there is no scene to show them in. */
  lead(leads: Lead[], loose: LooseThing[]): boolean {
    if (this.isReady) this.view?.lead(leads, loose);
    return this.isReady;
  }

  /** Where a drag has things meanwhile. */
  drag(dragged: Item[]): void {
    const ghosts = new Map(dragged.map((ghost) => [keyOf(ghost.path), ghost]));
    this.view?.drag(ghosts.size ? (item) => ghosts.get(keyOf(item.path)) ?? item : null);
  }

  /** What robots measure, believe and show now. */
  think(thought: Thoughts): void {
    this.thought = thought;
    if (this.open) this.view?.think(thought);
  }

  /** Ask where things are now, when there is time for it. */
  poses(order: () => Promise<ArrayBuffer>): void {
    this.order = order;
    if (this.open && this.view && this.loaded !== null) this.moved(order);
  }

  private async load(key: unknown): Promise<void> {
    if (!this.open || this.loaded === key) return;
    try {
      const view = await this.made();
      const scene = await this.scene();
      // Bodies of a later scene have other places.
      if (this.asked !== key) return;
      await view.load(scene, this.world);
      if (this.asked !== key) return;
      this.loaded = key;
      if (this.order) this.moved(this.order);
      this.element.dataset["scene"] = "there";
      this.ready.emit();
    } catch (error) {
      if (!(error instanceof Error)) throw error;
      if (this.asked !== key) return;
      const code = error instanceof ApiError && JSON.stringify(error.data["needs_trust"]);
      const isNew = Boolean(code) && code !== this.declined;
      this.say(
        error.message,
        code && !isNew ? el("button", { onclick: () => void this.ask(code) }, word("edit.lookAtWhatItIs")) : "",
      );
      if (code && isNew) await this.ask(code);
    }
  }

  /** Let the person allow code; about code that was not allowed, a button asks again. */
  private async ask(code: string): Promise<void> {
    this.declined = (await this.allow()) ? "" : code;
    // Another scene may be wanted meanwhile.
    this.wanted(this.asked);
  }

  private say(...told: (Node | string)[]): void {
    if (this.view) this.view.say(...told);
    else this.element.replaceChildren(el("p", { class: "hint scene-none", role: "status" }, ...told));
  }

  private async move(order: () => Promise<ArrayBuffer>): Promise<void> {
    try {
      this.view?.pose(await order());
    } catch (error) {
      // The next news ask again.
      if (!(error instanceof ApiError)) throw error;
    }
  }

  private async made(): Promise<SceneView> {
    if (this.view) return this.view;
    const program = (await import(PROGRAM)) as typeof import("./scene");
    const view = new program.SceneView(word);
    view.chosen.on((item) => this.chosen.emit(item));
    view.handles.pulled.on((pull) => this.pulled.emit(pull));
    view.leads.led.on((led) => this.led.emit(led));
    view.loose.put.on((put) => this.put.emit(put));
    view.slow.on((rate) => this.slow.emit(rate));
    view.aim.told.on((way) => this.aimed.emit(way));
    view.aim.set(this.aims);
    view.show(...this.shown);
    view.hold(...this.held);
    view.think(this.thought);
    this.element.replaceChildren(view.element);
    return (this.view = view);
  }
}
