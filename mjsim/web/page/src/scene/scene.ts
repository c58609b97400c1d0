/** The view in 3-D of Edit, Run and Review: the scene, what is done with the mouse, and a bar with its switches. */

import { Box3, Group, type Intersection, Line, LineBasicMaterial, type Material, type Mesh, Vector3 } from "three";
import type { Item } from "../api";
import { Grids } from "../run/grids";
import { remembered, toggle } from "../ui/controls";
import { el } from "../ui/dom";
import { Signal } from "../ui/signal";
import { color } from "../ui/theme";
import { draw, options } from "../ui/view";
import { Aim } from "./aim";
import { takeAway } from "./away";
import { Axes } from "./axes";
import type { Grip, Lead, LooseThing } from "./grip";
import { Handles } from "./handles";
import { Leads } from "./leads";
import { Loose } from "./loose";
import { type AsDragged, clearMarks, heights, itemAt, MarkInk, markOf, points } from "./marks";
import { boxOfThings, countThings, dispose, pose, readSolids, type Solids, thingOf } from "./solids";
import { ABOVE, Stage3d } from "./stage";
import { forget, type Thoughts, thoughtsOf } from "./thoughts";
import { Touching } from "./touching";

/** What looks up words. The page gives its own, so that their table is in one program only. */
type Look = typeof import("../words/words").word;

/** Views from one side, and where the eye stands then. */
const SIDES = [
  // North is up, and not undefined.
  ["scene.fromTheTop", new Vector3(0, -1e-4, 1)],
  ["scene.fromTheFront", new Vector3(0, -1, 0)],
  ["scene.fromTheSide", new Vector3(1, 0, 0)],
] as const;

export class SceneView {
  readonly element = el("div", { class: "scene" });
  /** What was picked; null: nothing of the world. */
  readonly chosen = new Signal<Item | null>();
  private readonly stage: Stage3d;
  private readonly said = el("output", { class: "scene-said" });
  private readonly note: HTMLElement;
  private readonly follow: HTMLSelectElement;
  private readonly eye: HTMLSelectElement;
  private readonly ruler: HTMLButtonElement;
  private solids: Solids | null = null;
  private world: string | null = null;
  private items: Item[] = [];
  private selected: Item[] = [];
  private dragged: AsDragged | null = null;
  private grip: Grip | null = null;
  readonly aim: Aim;
  readonly handles: Handles;
  readonly leads: Leads;
  readonly loose: Loose;
  /** Told with the pictures a second when those are too few. */
  readonly slow: Signal<number>;
  private readonly marks = new Group();
  private readonly ink = new MarkInk();
  private readonly measure = new Group();
  private readonly touching = new Touching();
  /** How often bodies were put where they are. */
  private moments = 0;
  /** Names of what is away, in one line. */
  private away = "";
  private thoughts = new Group();
  private thought: Thoughts | null = null;
  private readonly retired: Material[] = [];
  private readonly grids = new Grids(() => this.think(this.thought));
  private ends: Vector3[] = [];
  private followed: Vector3 | null = null;

  constructor(private readonly word: Look) {
    this.stage = new Stage3d(word("scene.theWorldIn3d"), word("scene.noGraphics"));
    this.aim = new Aim(this.stage);
    this.handles = new Handles(this.stage);
    this.leads = new Leads(this.stage);
    this.loose = new Loose(this.stage);
    this.slow = this.stage.pacing.slow;
    this.note = el("p", { class: "hint scene-note", role: "status" }, word("scene.loading"));
    this.follow = el("select", { "aria-label": word("scene.follow") });
    this.eye = el("select", { "aria-label": word("scene.lookFrom") });
    const measure = { "aria-pressed": "false", onclick: () => this.setRuler(!this.measuring) };
    this.ruler = el("button", { class: "quiet", type: "button", ...measure }, word("scene.measure"));
    const fit = (): void => this.stage.fit();
    const whole = el("button", { class: "quiet", type: "button", onclick: fit }, word("scene.showAll"));
    const isEdged = remembered("scene.edges") === "yes";
    const edges = toggle({ class: "quiet" }, isEdged, (on) => this.setEdges(on), word("scene.edges"));
    this.stage.setEdges(isEdged);
    const bar = el("div", { class: "scene-bar", role: "group", "aria-label": word("scene.bar") });
    bar.append(this.eye, this.follow, whole, edges, this.ruler, this.said);
    const axes = new Axes();
    this.stage.drawing.on((eye) => axes.show(eye));
    this.element.append(this.stage.canvas, axes.element, this.leads.notes, this.loose.notes, bar, this.note);
    this.stage.over.add(this.marks, this.measure, this.touching.group);
    this.stage.picked.on((hit) => this.pick(hit));
    this.stage.freed.on(() => (this.eye.value = ""));
    this.follow.addEventListener("change", () => this.setFollowed());
    this.eye.addEventListener("change", () => {
      const [, from] = SIDES.find(([name]) => name === this.eye.value) ?? [];
      if (from) this.look(this.eye.value, from);
      else this.setEye();
    });
    this.stage.controls.addEventListener("start", () => this.stage.isFree && (this.eye.value = ""));
  }

  /** Show another scene; the view stays where it is unless the world is another. */
  async load(data: ArrayBuffer, world: string): Promise<void> {
    const solids = await readSolids(data);
    const isOther = world !== this.world;
    this.world = world;
    if (isOther) this.follow.value = this.eye.value = "";
    if (this.solids) dispose(this.solids);
    this.solids = solids;
    this.away = "";
    this.stage.things = countThings(solids.root);
    this.stage.show(solids.root, () => boxOfThings(solids.root));
    this.offer(solids);
    this.mark();
    this.note.hidden = true;
    this.element.toggleAttribute("data-filled", true);
    if (isOther) this.stage.fit();
  }

  /** Say why there is nothing to see. */
  say(...told: (Node | string)[]): void {
    this.note.hidden = false;
    this.note.replaceChildren(...told);
  }

  /** Put what moves where it is. */
  pose(data: ArrayBuffer): void {
    if (!this.solids) return;
    const { time, contacts, removed } = pose(this.solids, data);
    this.canvas.dataset["time"] = String(time);
    this.canvas.dataset["moments"] = String(++this.moments);
    this.canvas.dataset["contacts"] = String(contacts.length / 4);
    this.touching.show(contacts);
    this.takeAway(removed);
    this.goAlong();
    this.stage.moved();
  }

  private takeAway(names: string[]): void {
    const line = names.join("\n");
    if (line === this.away || !this.solids) return;
    this.away = line;
    this.canvas.dataset["away"] = names.join();
    takeAway(this.solids.root, names);
  }

  /** Draw what robots measure, believe and show; null for nothing. */
  think(thought: Thoughts | null): void {
    this.thought = thought;
    forget(this.thoughts, this.retired);
    this.stage.over.remove(this.thoughts);
    if (thought) this.stage.over.add((this.thoughts = thoughtsOf(thought, this.grids)));
    this.touching.group.visible = thought?.shown.contacts ?? true;
    this.canvas.dataset["thoughts"] = String(this.thoughts.children.length);
    this.stage.soon();
  }

  /** What can be picked, and what of it is selected. */
  show(items: Item[], selected: Item[]): void {
    this.items = items;
    this.selected = selected;
    this.mark();
  }

  /** By which handles what is selected is held; what is said about it. */
  hold(grip: Grip | null, said: string): void {
    this.grip = grip;
    if (!this.measuring) this.said.value = said;
    this.mark();
  }

  /** Which tools and hands can be led, and which things dragged. */
  lead(leads: Lead[], loose: LooseThing[]): void {
    const bodies = new Map(this.solids?.bodies.map((body) => [String(body.userData["name"]), body]) ?? []);
    this.leads.show(leads, (name) => bodies.get(name) ?? null);
    this.loose.show(loose, this.solids?.bodies ?? []);
  }

  /** Where a drag has things meanwhile; null: it is over. */
  drag(dragged: AsDragged | null): void {
    this.dragged = dragged;
    this.mark();
  }

  /** It has come on the screen. */
  shown(): void {
    this.stage.soon();
  }

  /** Take up the colours of the theme. */
  recolor(): void {
    this.stage.recolor();
    this.touching.recolor();
    this.leads.recolor();
    this.ink.recolor();
    this.think(this.thought);
    this.mark();
  }

  get canvas(): HTMLCanvasElement {
    return this.stage.canvas;
  }

  private get measuring(): boolean {
    return this.ruler.getAttribute("aria-pressed") === "true";
  }

  private mark(): void {
    clearMarks(this.marks);
    if (this.solids && this.selected.length)
      this.marks.add(markOf(this.selected, this.solids.root, this.dragged ?? ((item) => item), this.ink));
    if (!this.dragged) this.handles.hold(this.measuring ? null : this.grip, this.middle());
    this.canvas.dataset["selected"] = this.selected.map((item) => item.label).join();
    this.stage.soon();
  }

  /** How high the middle of what is selected is [m]. */
  private middle(): number {
    const [first] = this.selected;
    if (!first || !this.solids || !this.grip) return 0;
    const [low, high] = heights(first, this.solids.root);
    return (low + high) / 2;
  }

  private pick(hit: Intersection | null): void {
    if (this.measuring) return this.lay(hit);
    const thing = hit && typeof hit.faceIndex === "number" ? thingOf(hit.object as Mesh, hit.faceIndex) : "";
    this.chosen.emit(hit ? itemAt(this.items, thing, hit.point) : null);
  }

  private setRuler(on: boolean): void {
    this.ruler.setAttribute("aria-pressed", String(on));
    this.ends = [];
    clearMarks(this.measure);
    this.said.value = on ? this.word("scene.pressTwoPlaces") : "";
    this.mark();
  }

  /** Lay one end of the ruler; with the second one the distance is said. */
  private lay(hit: Intersection | null): void {
    if (!hit) return;
    if (this.ends.length > 1) this.ends = [];
    this.ends.push(hit.point.clone());
    clearMarks(this.measure);
    const [from, to] = this.ends;
    if (!from || !to) {
      this.said.value = this.word("scene.pressTheOtherPlace");
      return;
    }
    const line = new Line(
      points([...from.toArray(), ...to.toArray()]),
      new LineBasicMaterial({ color: color("--seen"), depthTest: false }),
    );
    line.renderOrder = 3;
    this.measure.add(line);
    const parts = { distance: from.distanceTo(to), level: Math.hypot(to.x - from.x, to.y - from.y), up: to.z - from.z };
    const figures = Object.entries(parts).map(([name, length]) => [name, length.toFixed(3)]);
    this.said.value = this.word("scene.distance", Object.fromEntries(figures) as Record<string, string>);
    this.stage.soon();
  }

  private offer({ bodies, cameras }: Solids): void {
    const names = bodies.slice(1).map((body) => String(body.userData["name"]));
    const robots = names.filter((name) => name.endsWith("/base"));
    const followed = [
      ["", this.word("scene.followNothing")] as const,
      ...robots.map((name) => [name, this.word("scene.followRobot", { name: name.split("/")[0] })] as const),
    ];
    const aboard = [...cameras.keys()].filter((name) => name.includes("/") && !name.endsWith("/chase"));
    const eyes = [
      ["", this.word("scene.fromAnywhere")] as const,
      ...SIDES.map(([name]) => [name, this.word(name)] as const),
      ...aboard.map((name) => [name, this.word("scene.camera", { name })] as const),
    ];
    draw(this.follow, options(followed, this.follow.value));
    draw(this.eye, options(eyes, this.eye.value));
    this.follow.hidden = robots.length === 0;
    this.setEye();
    this.followed = this.place();
  }

  private setEye(): void {
    this.stage.ride(this.solids?.cameras.get(this.eye.value) ?? null);
  }

  private look(side: string, from: Vector3): void {
    this.stage.fit(from);
    this.eye.value = side;
  }

  private setEdges(on: boolean): void {
    remembered("scene.edges", on ? "yes" : "no");
    this.stage.setEdges(on);
  }

  private setFollowed(): void {
    this.followed = this.place();
    const body = this.followedBody();
    if (!body || !this.followed) return;
    const size = new Box3().setFromObject(body).getSize(new Vector3()).length();
    this.stage.lookAt(this.followed, 8 * size, ABOVE);
  }

  private followedBody(): Solids["bodies"][number] | null {
    return (
      this.solids?.bodies.find((body) => this.follow.value !== "" && body.userData["name"] === this.follow.value) ??
      null
    );
  }

  private place(): Vector3 | null {
    return this.followedBody()?.position.clone() ?? null;
  }

  private goAlong(): void {
    const now = this.place();
    if (now && this.followed) this.stage.shift(now.clone().sub(this.followed));
    this.followed = now;
  }
}
