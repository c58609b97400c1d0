/** Handles in 3-D by which what is selected is moved, turned and lifted; they are as large at any distance. */

import { Group, LineBasicMaterial, LineSegments, Vector3 } from "three";
import type { Point } from "../api";
import { add, direction, dot, minus, times } from "../plan/geometry";
import { Signal } from "../ui/signal";
import { color } from "../ui/theme";
import { clearHandles, Gesture, handleLength, inFront, inkOf, knobMesh, knobsNear, type Owner } from "./gesture";
import type { Grip, Pull } from "./grip";
import { points } from "./marks";
import type { Stage3d } from "./stage";

/** A circle is drawn with so many corners. */
const ROUND = 48;
/** What can be taken, at a place in units of the handles' length. */
interface Knob {
  kind: Pull["kind"];
  place: Vector3;
  /** The only direction that it goes in. */
  way?: Point;
}

interface Held {
  knob: Knob;
  grip: Grip;
  /** What the handle is about, and where it was taken, world frame [m]. */
  middle: Vector3;
  taken: Vector3;
  last: Pull | null;
}

export class Handles implements Owner {
  readonly group = new Group();
  readonly pulled = new Signal<Pull>();
  private grip: Grip | null = null;
  private knobs: Knob[] = [];
  private held: Held | null = null;

  constructor(private readonly stage: Stage3d) {
    stage.over.add(this.group);
    stage.drawing.on(() => this.scale());
    new Gesture(stage, this);
  }

  /** Hold a thing whose middle is so high [m]; null: nothing. */
  hold(grip: Grip | null, height: number): void {
    this.grip = grip;
    clearHandles(this.group);
    this.knobs = grip ? knobsOf(grip) : [];
    if (grip) {
      this.group.position.set(...grip.at, height);
      draw(this.group, grip, this.knobs);
    }
    this.scale();
  }

  private scale(): void {
    this.group.scale.setScalar(handleLength(this.stage, this.group.position));
    this.group.updateMatrixWorld();
    this.stage.orbit.updateMatrixWorld();
    const places = this.knobs.map((knob) => [knob.kind, ...this.stage.onCanvas(this.placeOf(knob)).map(Math.round)]);
    this.stage.canvas.dataset["handles"] = JSON.stringify(places);
  }

  private placeOf(knob: Knob): Vector3 {
    return knob.place.clone().applyMatrix4(this.group.matrixWorld);
  }

  take(event: PointerEvent): boolean {
    const knob = this.knobAt(event);
    if (!knob || !this.grip) return false;
    this.held = { knob, grip: this.grip, middle: this.group.position.clone(), taken: this.placeOf(knob), last: null };
    return true;
  }

  hover(event: PointerEvent): void {
    this.stage.canvas.style.cursor = this.knobAt(event) ? "grab" : "";
  }

  drag(event: PointerEvent): void {
    const { held } = this;
    if (!held) return;
    held.last = this.pull(held, event) ?? held.last;
    if (!held.last) return;
    this.goAlong(held.last, held.middle);
    this.pulled.emit(held.last);
  }

  end(done: boolean): void {
    const last = this.held?.last;
    this.held = null;
    if (last) this.pulled.emit({ ...last, phase: done ? "up" : "cancel" });
  }

  /** The handles stay with what they hold. */
  private goAlong({ kind, to, rise }: Pull, { x, y, z }: Vector3): void {
    this.group.position.set(...(kind === "move" ? to : ([x, y] as Point)), z + rise);
    this.stage.soon();
  }

  /** What a drag to a place of the page comes to; null when it looks into the sky there. */
  private pull({ knob, grip, middle, taken }: Held, event: PointerEvent): Pull | null {
    const { kind, way } = knob;
    const told = { kind, phase: "drag" as const, along: way !== undefined && grip.axes.length > 1, alt: event.altKey };
    if (kind === "lift") {
      const to = this.stage.onUpright(event.clientX, event.clientY, taken);
      return to && { ...told, from: grip.at, to: grip.at, rise: to.z - taken.z };
    }
    const to = this.stage.onLevel(event.clientX, event.clientY, taken.z);
    if (!to) return null;
    if (kind === "turn") return { ...told, from: [taken.x, taken.y], to: [to.x, to.y], rise: 0 };
    const by = minus([to.x, to.y], [taken.x, taken.y]);
    return { ...told, from: grip.at, to: add([middle.x, middle.y], way ? times(way, dot(by, way)) : by), rise: 0 };
  }

  private knobAt(event: PointerEvent): Knob | null {
    return knobsNear(this.stage, event, this.knobs, (knob) => this.placeOf(knob))[0] ?? null;
  }
}

function knobsOf(grip: Grip): Knob[] {
  const ways = grip.axes.map((angle): Knob => {
    const way = direction(angle);
    return { kind: "move", place: new Vector3(...way, 0), way };
  });
  const knobs: Knob[] = ways.length > 1 ? [{ kind: "move", place: new Vector3() }, ...ways] : ways;
  if (grip.lift) knobs.push({ kind: "lift", place: new Vector3(0, 0, 1) });
  if (grip.heading !== null)
    knobs.push({ kind: "turn", place: new Vector3(...times(direction(grip.heading + 45), 0.7), 0) });
  return knobs;
}

/** Draw the knobs, the lines to them, and the circle along which one turns. */
function draw(group: Group, grip: Grip, knobs: Knob[]): void {
  const ink = inkOf(color("--accent"));
  const lines = knobs.flatMap(({ kind, place }) => (kind === "turn" ? [] : [0, 0, 0, ...place.toArray()]));
  if (grip.heading !== null) lines.push(...circle(0.7));
  const made = knobs.map(({ kind, place }) => knobMesh(place, kind === "turn" ? inkOf(color("--seen")) : ink));
  inFront(group, ...made, new LineSegments(points(lines), new LineBasicMaterial(ink)));
}

function circle(radius: number): number[] {
  const corner = (k: number): number[] => [...times(direction((360 * k) / ROUND), radius), 0];
  return Array.from({ length: ROUND }, (_, k) => [...corner(k), ...corner(k + 1)]).flat();
}
