/**
 * Handles in 3-D at tools, hands and joints. Tools and hands are led in the plane that faces who looks, the last one taken
 * along x, y, z too; a joint only as it moves.
 */

import { Group, LineBasicMaterial, LineSegments, Matrix4, type Object3D, Vector3 } from "three";
import type { Point } from "../api";
import {
  type Change,
  changeTo,
  goesOn,
  gripAfter,
  isFrozen,
  jointAfter,
  type LetGo,
  letGoOf,
  rankOf,
} from "../run/joint_grips";
import { el } from "../ui/dom";
import { Signal } from "../ui/signal";
import { color } from "../ui/theme";
import { clearHandles, Gesture, handleLength, inFront, inkOf, knobMesh, knobsNear, type Owner } from "./gesture";
import type { Lead, Led } from "./grip";
import { points } from "./marks";
import type { Stage3d } from "./stage";

const WAYS = { x: new Vector3(1, 0, 0), y: new Vector3(0, 1, 0), z: new Vector3(0, 0, 1) };
type Way = keyof typeof WAYS;

interface Knob {
  key: string;
  /** The only direction that it goes in; null: in the plane that faces who looks. */
  way: Way | null;
}

interface Held extends Knob {
  /** Where the handle was, and where it was taken, world frame [m]. */
  from: Vector3;
  taken: Vector3;
  to: Vector3 | null;
  /** What is held, as it is now and as it was taken. */
  lead: Lead;
  first: Lead;
  /** By how much a joint is to move. */
  by: Change;
  /** Where the pointer was last, once it has moved. */
  pointer: Point | null;
  /** Of a joint that was let go and goes on to where that was. */
  letGo?: LetGo | null;
}

type Find = (body: string) => Object3D | null;

export class Leads implements Owner {
  readonly led = new Signal<Led>();
  /** What is written beside handles. */
  readonly notes = el("div", { class: "scene-notes" });
  private readonly group = new Group();
  /** The line from what is led to where it is to be. */
  private readonly thread = new LineSegments(
    points([0, 0, 0, 0, 0, 1]),
    new LineBasicMaterial(inkOf(color("--accent"))),
  );
  private leads: Lead[] = [];
  private find: Find = () => null;
  /** Which of them has handles along axes. */
  private active = "";
  private held: Held | null = null;
  private shown = "";
  private readonly gesture: Gesture;

  constructor(private readonly stage: Stage3d) {
    stage.over.add(this.group, inFront(new Group(), this.thread));
    this.thread.frustumCulled = this.thread.visible = false;
    stage.drawing.on(() => this.scale());
    this.gesture = new Gesture(stage, this);
  }

  /** Put handles where tools and hands are now; `find` gives bodies that move. */
  show(leads: Lead[], find: Find): void {
    [this.leads, this.find] = [leads, find];
    if (!this.leads.some(({ key }) => key === this.active))
      this.active = this.leads.find(({ joint }) => !joint)?.key ?? "";
    if (this.held && !this.leads.some(({ key }) => key === this.held?.key)) this.gesture.giveUp();
    this.build();
    // A joint of a loop comes nearer to a pointer that rests.
    if (this.held?.pointer && this.held.lead.joint?.grip.toward) this.turn(this.held, this.held.pointer);
    if (this.held?.letGo && !(this.held.lead.joint && goesOn(this.held.lead.joint, this.held.by, this.held.letGo)))
      this.finish(this.held);
    this.stage.soon();
  }

  recolor(): void {
    this.shown = "";
    this.thread.material.color.set(color("--accent"));
    this.build();
  }

  /** Make handles anew where there are others. */
  private build(): void {
    const shown = [this.active, ...this.leads.map(({ key }) => key)].join("\n");
    if (shown !== this.shown) {
      this.shown = shown;
      clearHandles(this.group);
      for (const lead of this.leads) this.group.add(lead.joint ? drawnJoint() : drawn(lead.key === this.active));
    }
    this.scale();
  }

  private scale(): void {
    this.leads.forEach((lead, k) => {
      const made = this.group.children[k];
      const place = this.placeOf(lead);
      made?.position.copy(place);
      made?.scale.setScalar(handleLength(this.stage, place));
      if (lead.joint && made)
        pointTo(made, new Vector3(...lead.joint.grip.at).sub(place).divideScalar(handleLength(this.stage, place)));
    });
    this.pull();
    this.stage.orbit.updateMatrixWorld();
    this.write();
    const places = this.knobs().map((knob) => [
      knob.key,
      knob.way ?? "",
      ...this.stage.onCanvas(this.knobPlace(knob)).map(Math.round),
    ]);
    this.stage.canvas.dataset["leads"] = JSON.stringify(places);
  }

  /** Draw the line from what is held to where it is to be. */
  private pull(): void {
    const lead = this.leads.find(({ key }) => key === this.held?.key);
    const to = this.held?.to;
    this.thread.visible = Boolean(lead && to);
    if (!lead || !to) return;
    const places = this.thread.geometry.getAttribute("position");
    places.setXYZ(0, ...new Vector3(...lead.at).applyMatrix4(this.frame(lead)).toArray());
    places.setXYZ(1, ...to.toArray());
    places.needsUpdate = true;
  }

  /** Write beside each handle what there is to say of it. */
  private write(): void {
    const said = this.leads.filter(({ note }) => note !== undefined);
    while (this.notes.children.length > said.length) this.notes.lastElementChild?.remove();
    said.forEach((lead, k) => {
      const note = (this.notes.children[k] as HTMLElement | undefined) ?? this.notes.appendChild(el("span", {}));
      const [x, y] = this.stage.onCanvas(this.placeOf(lead));
      if (note.textContent !== lead.note) note.textContent = lead.note ?? "";
      note.style.transform = `translate(${Math.round(x)}px, ${Math.round(y)}px)`;
    });
  }

  private knobs(): Knob[] {
    const free = this.leads.map(({ key }): Knob => ({ key, way: null }));
    const ways = (Object.keys(WAYS) as Way[]).map((way): Knob => ({ key: this.active, way }));
    return this.active ? [...free, ...ways] : free;
  }

  /** Where one is, or is led by the pointer, world frame [m]. */
  private placeOf(lead: Lead): Vector3 {
    if (this.held?.key === lead.key && this.held.to) return this.held.to.clone();
    return new Vector3(...lead.at).applyMatrix4(this.frame(lead));
  }

  /** The frame of its place in the world. */
  private frame({ body, stands: [x, y, heading] }: Lead): Matrix4 {
    const found = this.find(body);
    if (!found) return new Matrix4().makeRotationZ(heading).setPosition(x, y, 0);
    found.updateMatrixWorld();
    return found.matrixWorld;
  }

  private knobPlace({ key, way }: Knob): Vector3 {
    const lead = this.leads.find((each) => each.key === key);
    const place = lead ? this.placeOf(lead) : new Vector3();
    return way ? place.addScaledVector(WAYS[way], handleLength(this.stage, place)) : place;
  }

  take(event: PointerEvent): boolean {
    const knob = this.knobAt(event);
    const lead = this.leads.find(({ key }) => key === knob?.key);
    if (!knob || !lead) return false;
    if (this.held) this.finish(this.held);
    const [from, taken] = [this.knobPlace({ ...knob, way: null }), this.knobPlace(knob)];
    this.held = { ...knob, from, taken, to: null, lead, first: lead, by: 0, pointer: null };
    if (!lead.joint) this.active = knob.key;
    this.build();
    return true;
  }

  hover(event: PointerEvent): void {
    if (this.knobAt(event)) this.stage.canvas.style.cursor = "grab";
  }

  drag({ clientX, clientY }: PointerEvent): void {
    const { held, stage } = this;
    if (!held) return;
    held.pointer = [clientX, clientY];
    if (held.lead.joint) return this.turn(held, held.pointer);
    const seen = held.way
      ? stage.onLine(clientX, clientY, held.taken, WAYS[held.way])
      : stage.onFacing(clientX, clientY, held.taken);
    if (seen) held.to = held.from.clone().add(seen.sub(held.taken));
    if (held.to) this.tell(held, held.to, "drag");
    stage.soon();
  }

  /** Take a joint to where its handle is seen nearest to a place of the page. */
  private turn(held: Held, [x, y]: Point): void {
    const lead = this.leads.find(({ key }) => key === held.key);
    // In a loop its axis moves with its value, and it is taken to where it was.
    if (lead?.joint && !isFrozen(lead.joint.grip)) held.lead = lead;
    const { joint } = held.lead;
    if (!joint) return;
    const { left, top } = this.stage.canvas.getBoundingClientRect();
    held.by = changeTo(joint, (place) => this.stage.onCanvas(new Vector3(...place)), [x - left, y - top]);
    held.to = new Vector3(...gripAfter(joint.grip, held.by));
    this.stage.canvas.dataset["turned"] = String(held.by);
    this.tell(held, held.to, "drag");
    this.stage.soon();
  }

  end(done: boolean): void {
    const { held } = this;
    if (!held) return;
    held.letGo = held.lead.joint ? letGoOf(held.lead.joint, held.by) : null;
    if (done) return held.letGo ? undefined : this.finish(held);
    this.held = null;
    this.stage.soon();
    // A joint goes back to where it was taken.
    if (held.to) this.tell({ ...held, lead: held.first, by: 0 }, held.from, "cancel");
  }

  private finish(held: Held): void {
    this.held = null;
    this.stage.soon();
    if (held.to) this.tell(held, held.to, "up");
  }

  private tell(held: Held, to: Vector3, phase: Led["phase"]): void {
    const lead = this.leads.find(({ key }) => key === held.key);
    if (!lead) return;
    const { joint } = held.lead;
    if (joint)
      return this.led.emit({
        key: lead.key,
        phase,
        to: to.toArray(),
        joint: phase === "cancel" ? joint : jointAfter(joint, held.by),
      });
    this.led.emit({ key: lead.key, phase, to: to.clone().applyMatrix4(this.frame(lead).clone().invert()).toArray() });
  }

  private knobAt(event: PointerEvent): Knob | null {
    const ranks = new Map(this.leads.map(({ key, joint }) => [key, joint ? rankOf(joint.grip) : 0]));
    const found = knobsNear(this.stage, event, this.knobs(), (knob) => this.knobPlace(knob));
    // What is led anywhere comes before joints beside it, which come apart from it as one goes nearer.
    return found.sort((a, b) => (ranks.get(a.key) ?? 0) - (ranks.get(b.key) ?? 0))[0] ?? null;
  }
}

/** A knob that is smaller, with the line to the axis of its joint. */
function drawnJoint(): Group {
  const ink = inkOf(color("--seen"));
  return inFront(
    new Group(),
    knobMesh(new Vector3(), ink, 0.8),
    new LineSegments(points([0, 0, 0, 0, 0, 1]), new LineBasicMaterial(ink)),
  );
}

/** Let the line of a joint's knob end there, in units of the handles' length. */
function pointTo(knob: Object3D, { x, y, z }: Vector3): void {
  const line = knob.children.find((part) => part instanceof LineSegments);
  const places = line && (line as LineSegments).geometry.getAttribute("position");
  places?.setXYZ(1, x, y, z);
  if (places) places.needsUpdate = true;
}

/** A knob, with those along the axes and the lines to them where it is the one that was taken last. */
function drawn(active: boolean): Group {
  const ink = inkOf(color("--accent"));
  const places = [new Vector3(), ...(active ? Object.values(WAYS) : [])];
  const lines = places.flatMap((place) => [0, 0, 0, ...place.toArray()]);
  return inFront(
    new Group(),
    ...places.map((place) => knobMesh(place, ink)),
    new LineSegments(points(lines), new LineBasicMaterial(ink)),
  );
}
