/** The tools of the Edit view, their buttons, and what can be chosen for them. */

import type { Values } from "../api";
import { chooseRobot, chooser, nameOf } from "../panel/gallery";
import { choosePicture, hangable } from "../panel/pictures";
import type { SchemaBook } from "../panel/schema";
import type { Tool } from "../plan/gestures";
import { el } from "../ui/dom";
import { sign } from "../ui/icons";
import { Signal } from "../ui/signal";
import { choice, draw, html, nothing, tickBox, type View } from "../ui/view";
import { word } from "../words/words";
import { freshMarker, nextUnused } from "./copies";
import type { Editor } from "./editor";
import { MoreThings } from "./more_things";
import { OpeningTool } from "./opening_tool";
import { beaconMaker, makeBox, makeCylinder, PlaceTool, robotMaker } from "./place_tool";
import { SelectTool } from "./select_tool";
import { WallTool } from "./wall_tool";

export const TOOLS = [
  { name: "select", title: word("edit.select"), key: "V" },
  { name: "hand", title: word("edit.moveThePaper"), key: "H" },
  { name: "wall", title: word("edit.wall"), key: "W" },
  { name: "door", title: word("edit.doorway"), key: "D" },
  { name: "window", title: word("edit.window"), key: "N" },
  { name: "box", title: word("edit.box"), key: "B" },
  { name: "cylinder", title: word("edit.cylinder"), key: "C" },
  { name: "beacon", title: word("edit.pictureOrMarker"), key: "P" },
  { name: "robot", title: word("edit.robot"), key: "R" },
  { name: "more", title: word("edit.moreThings"), key: "M" },
] as const;

export type ToolName = (typeof TOOLS)[number]["name"];

const HINTS: Record<ToolName, string> = {
  select: word("edit.dragThingsOrFreePaper"),
  hand: word("edit.dragThePaper"),
  wall: word("edit.clickCornerByCornerEnter"),
  door: word("edit.clickOnAWall"),
  window: word("edit.clickOnAWall"),
  box: word("edit.clickOrDragFromCorner"),
  cylinder: word("edit.clickOrDragFromIts"),
  beacon: word("edit.clickNearAWallIt"),
  robot: word("edit.clickOrDragToWhere"),
  more: "",
};
const BEACONS = [
  ["picture", word("edit.picture")],
  ["marker", word("edit.marker")],
  ["reflector", word("edit.reflector")],
  ["anchor", word("edit.anchor")],
] as const;

export class Tools {
  readonly bar = el("div", {
    class: "tools",
    role: "toolbar",
    "aria-label": word("edit.tools"),
    "aria-orientation": "vertical",
  });
  /** The choices of the tool; the view appends controls of its own. */
  readonly strip = el("div", { class: "strip" });
  private readonly chosen = el("div", { class: "strip-tool" });
  readonly changed = new Signal<ToolName>();
  readonly wall: WallTool;
  private readonly more: MoreThings;
  readonly select: SelectTool;
  now: ToolName = "select";
  /** Where the pointer is. */
  private readonly where = el("span", { class: "where", "aria-hidden": "true" });
  private picture = "posters/lion.jpg";
  private look: (typeof BEACONS)[number][0] = "picture";
  private preset = "";
  /** Sensors that a new robot may bring: a word for each, and its first keys, by the names of their models. */
  private readonly offered: Map<string, { title: string; value: unknown }>;
  private readonly sensors = new Set(["camera"]);
  /** Pictures that were hung up and may not be among the items yet. */
  private readonly hanging = new Set<string>();
  private readonly tools: Record<ToolName, Tool | null>;

  constructor(
    private readonly editor: Editor,
    book: SchemaBook,
  ) {
    this.offered = book.offers("Robot", "sensors");
    const { shipped } = editor.studio.folder;
    if (!shipped.pictures.includes(this.picture)) this.picture = shipped.pictures[0] ?? this.picture;
    this.preset = (shipped.presets.find(({ name }) => name === "pioneer3dx") ?? shipped.presets[0])?.name ?? "";
    this.wall = new WallTool(editor);
    this.more = new MoreThings(editor);
    this.select = new SelectTool(editor);
    this.tools = {
      select: this.select,
      hand: null,
      wall: this.wall,
      door: new OpeningTool(editor, "door"),
      window: new OpeningTool(editor, "window"),
      box: new PlaceTool(editor, makeBox),
      cylinder: new PlaceTool(editor, makeCylinder),
      beacon: new PlaceTool(
        editor,
        beaconMaker(() => this.beacon()),
        ({ value }) => this.hung(value["image"]),
      ),
      robot: new PlaceTool(
        editor,
        robotMaker(() => this.robot()),
      ),
      more: this.more.tool,
    };
    this.strip.append(this.chosen);
    const { host } = editor.plan;
    host.addEventListener("pointermove", (event) => this.tell(event));
    host.addEventListener("pointerleave", () => (this.where.textContent = ""));
    // An unfinished wall belongs to the world in which it was begun.
    editor.document.opened.on(() => this.wall.cancel());
    this.take("select");
  }

  get tool(): Tool | null {
    return this.tools[this.now];
  }

  take(name: ToolName): void {
    if (name !== "wall") this.wall.finish(false);
    if (name === "beacon" && this.now !== "beacon") this.offerUnused();
    this.now = name;
    this.editor.plan.tool = this.tools[name];
    draw(
      this.bar,
      TOOLS.map((tool) => this.button(tool)),
    );
    this.drawStrip();
    this.changed.emit(name);
  }

  /** The tool of a letter; false when there is none. */
  takeKey(key: string): boolean {
    const found = TOOLS.find((tool) => tool.key === key.toUpperCase());
    if (found) this.take(found.name);
    return found !== undefined;
  }

  /** How a dropped picture is put in. */
  beaconOf(path: string): PlaceTool {
    return new PlaceTool(
      this.editor,
      beaconMaker(() => pictureBeacon(path)),
    );
  }

  private tell(event: PointerEvent): void {
    const box = this.editor.plan.host.getBoundingClientRect();
    const [x, y] = this.editor.plan.toWorld([event.clientX - box.left, event.clientY - box.top]);
    this.where.textContent = `${x.toFixed(2)}, ${y.toFixed(2)} m`.replaceAll("-", "−");
  }

  private button({ name, title, key }: (typeof TOOLS)[number]): View {
    const label = `${title} (${key})`;
    const isNow = name === this.now;
    const hasGap = ["hand", "window", "cylinder"].includes(name);
    return html`<button class="quiet square" title=${label} aria-label=${label} aria-keyshortcuts=${key}
      aria-pressed=${isNow} tabindex=${isNow ? 0 : -1} @click=${() => this.take(name)}
      @keydown=${(event: KeyboardEvent) => this.arrow(event, name)}>${sign(name)}</button>
      ${hasGap ? html`<span class="tool-gap"></span>` : nothing}`;
  }

  /** Arrows go through the tools, as in any tool bar: a column, or rows on a small screen. */
  private arrow(event: KeyboardEvent, name: ToolName): void {
    const step = ["ArrowDown", "ArrowRight"].includes(event.key)
      ? 1
      : ["ArrowUp", "ArrowLeft"].includes(event.key)
        ? -1
        : 0;
    if (!step) return;
    event.preventDefault();
    event.stopPropagation();
    const index = TOOLS.findIndex((tool) => tool.name === name) + step;
    const next = TOOLS[(index + TOOLS.length) % TOOLS.length];
    if (!next) return;
    this.take(next.name);
    this.bar.querySelector<HTMLElement>("[tabindex='0']")?.focus();
  }

  private drawStrip(): void {
    const hint = this.now === "more" ? this.more.hint : HINTS[this.now];
    const title = TOOLS.find((tool) => tool.name === this.now)?.title ?? "";
    draw(this.chosen, html`<b>${title}</b>${this.choices()}<span class="hint">${hint}</span>${this.where}`);
  }

  private choices(): View {
    if (this.now === "select") return this.adder();
    if (this.now === "beacon") return this.beaconChoices();
    if (this.now === "more") return this.more.choices(() => this.drawStrip());
    return this.now === "robot" ? this.robotChoices() : nothing;
  }

  /** Holds Shift for who has none. */
  private adder(): View {
    const press = (): void => {
      this.editor.adding = !this.editor.adding;
      this.drawStrip();
    };
    return html`<button class="adding" title=${word("edit.addWhatIsTouchedTo")} aria-pressed=${this.editor.adding}
      @click=${press}>${word("edit.several")}</button>`;
  }

  private beaconChoices(): View {
    const { studio, document } = this.editor;
    const look = (wanted: typeof this.look): void => {
      this.look = wanted;
      this.drawStrip();
    };
    const choose = async (): Promise<void> => {
      this.picture = (await choosePicture(studio)) ?? this.picture;
      this.drawStrip();
    };
    const pick = (): View => html`<button class="pick" title=${word("edit.chooseAPicture")} @click=${choose}><img
      src=${studio.api.picture(this.picture, 96, document.path)} alt=""><span class="path">${nameOf(this.picture)}</span></button>`;
    return [choice(word("edit.kind"), BEACONS, this.look, look), this.look === "picture" ? pick() : nothing];
  }

  private robotChoices(): View {
    const { studio } = this.editor;
    const choose = async (): Promise<void> => {
      this.preset = (await chooseRobot(studio)) ?? this.preset;
      this.drawStrip();
    };
    const set = (name: string, on: boolean): unknown => (on ? this.sensors.add(name) : this.sensors.delete(name));
    const boxes = [...this.offered].map(([name, { title }]) =>
      tickBox("check", title, this.sensors.has(name), (on) => set(name, on)),
    );
    const robot = chooser(studio, "robot", this.preset, word("edit.chooseARobot"), choose);
    return html`${robot}<div class="strip-boxes">${boxes}</div>`;
  }

  /** After a picture has been hung up, the next one is offered: of two alike neither is recognised. */
  private hung(image: unknown): void {
    if (typeof image !== "string") return;
    this.hanging.add(image);
    this.offerUnused();
    this.drawStrip();
  }

  private offerUnused(): void {
    const { items, studio } = this.editor;
    const images = items.flatMap(({ values }) => (typeof values["image"] === "string" ? values["image"] : []));
    for (const image of images) this.hanging.delete(image);
    this.picture = nextUnused(this.picture, hangable(studio), new Set([...images, ...this.hanging]));
  }

  private beacon(): { name: string; value: Values } {
    if (this.look === "picture") return pictureBeacon(this.picture);
    if (this.look === "reflector") return { name: "reflector", value: {} };
    if (this.look === "anchor") return { name: "anchor", value: { anchor: true } };
    const { name, marker } = freshMarker(this.editor.items);
    return { name, value: { marker, width: 0.3 } };
  }

  private robot(): Values {
    const sensors = [...this.offered].filter(([name]) => this.sensors.has(name)).map(([, { value }]) => value);
    return { name: "robot", ...(this.preset ? { preset: this.preset } : {}), ...(sensors.length ? { sensors } : {}) };
  }
}

function pictureBeacon(path: string): { name: string; value: Values } {
  const stem = nameOf(path).replace(/\.\w+$/, "");
  return { name: stem, value: { image: path, width: 0.6 } };
}
