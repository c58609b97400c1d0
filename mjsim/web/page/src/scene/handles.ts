/** Handles in 3-D by which what is selected is moved, turned and lifted; they are as large at any distance. */

import { Group, LineBasicMaterial, LineSegments, Mesh, MeshBasicMaterial, SphereGeometry, Vector3 } from "three";
import type { Point } from "../api";
import { add, direction, dot, minus, times } from "../plan/geometry";
import { color } from "../shell/theme";
import { Signal } from "../signal";
import type { Grip, Pull } from "./grip";
import { points } from "./marks";
import type { Stage3d } from "./stage";

/** How long a handle is, as a share of how far away the thing is. */
export const REACH = 0.13;
/** A knob, as a share of that. */
export const KNOB = 0.09;
/** A circle is drawn with so many corners. */
const ROUND = 48;
/** A knob is met within so many pixels; by a finger within more. */
export const NEAR = 12;
export const NEAR_FINGER = 24;
/** A press that moves less than this drags nothing [px]. */
export const STILL = 3;

/** What can be taken, at a place in units of the handles' length. */
interface Knob {
  kind: Pull["kind"];
  place: Vector3;
  /** The only direction that it goes in. */
  way?: Point;
}

interface Held {
  knob: Knob;
  start: PointerEvent;
  grip: Grip;
  /** What the handle is about, and where it was taken, world frame [m]. */
  middle: Vector3;
  taken: Vector3;
  moving: boolean;
  last: Pull | null;
}

export class Handles {
  readonly group = new Group();
  readonly pulled = new Signal<Pull>();
  private grip: Grip | null = null;
  private knobs: Knob[] = [];
  private held: Held | null = null;
  private readonly endings: (() => void)[] = [];

  constructor(private readonly stage: Stage3d) {
    stage.over.add(this.group);
    stage.drawing.on(() => this.scale());
    this.listen("pointerdown", (event) => this.down(event));
    this.listen("pointermove", (event) => this.move(event));
    this.listen("pointerup", (event) => this.isHolder(event) && this.end("up"));
    this.listen("pointercancel", (event) => this.isHolder(event) && this.end("cancel"));
    const escape = (event: KeyboardEvent): void => {
      if (event.key !== "Escape" || !this.held) return;
      event.stopImmediatePropagation();
      this.end("cancel");
    };
    window.addEventListener("keydown", escape, true);
    this.endings.push(() => window.removeEventListener("keydown", escape, true));
  }

  dispose(): void {
    for (const end of this.endings) end();
    this.clear();
  }

  /** Hold a thing whose middle is so high [m]; null: nothing. */
  hold(grip: Grip | null, height: number): void {
    this.grip = grip;
    this.clear();
    this.knobs = grip ? knobsOf(grip) : [];
    if (grip) {
      this.group.position.set(...grip.at, height);
      this.group.add(...drawn(grip, this.knobs));
    }
    this.scale();
  }

  private clear(): void {
    for (const part of this.group.children as (Mesh | LineSegments)[]) {
      part.geometry.dispose();
      (part.material as MeshBasicMaterial).dispose();
    }
    this.group.clear();
  }

  private scale(): void {
    this.group.scale.setScalar(Math.max(REACH * this.stage.orbit.position.distanceTo(this.group.position), 1e-3));
    this.group.updateMatrixWorld();
    this.stage.orbit.updateMatrixWorld();
    const places = this.knobs.map((knob) => [knob.kind, ...this.stage.onCanvas(this.placeOf(knob)).map(Math.round)]);
    this.stage.canvas.dataset["handles"] = JSON.stringify(places);
  }

  private placeOf(knob: Knob): Vector3 {
    return knob.place.clone().applyMatrix4(this.group.matrixWorld);
  }

  private listen(kind: "pointerdown" | "pointermove" | "pointerup" | "pointercancel", heard: (event: PointerEvent) => void): void {
    const { canvas } = this.stage;
    // Before the view itself is turned by the same press.
    const first = (event: PointerEvent): void => {
      const was = this.held;
      heard(event);
      if (was || this.held) event.stopImmediatePropagation();
    };
    canvas.addEventListener(kind, first, true);
    this.endings.push(() => canvas.removeEventListener(kind, first, true));
  }

  private down(event: PointerEvent): void {
    const knob = event.button || this.held ? null : this.knobAt(event);
    if (!knob || !this.grip) return;
    this.stage.canvas.setPointerCapture(event.pointerId);
    this.stage.canvas.focus();
    const [middle, taken] = [this.group.position.clone(), this.placeOf(knob)];
    this.held = { knob, start: event, grip: this.grip, middle, taken, moving: false, last: null };
  }

  private move(event: PointerEvent): void {
    const { held } = this;
    if (!held) {
      if (!event.buttons) this.stage.canvas.style.cursor = this.knobAt(event) ? "grab" : "";
      return;
    }
    if (!this.isHolder(event)) return;
    held.moving ||= Math.hypot(event.clientX - held.start.clientX, event.clientY - held.start.clientY) > STILL;
    if (!held.moving) return;
    held.last = this.pull(held, event) ?? held.last;
    if (!held.last) return;
    this.goAlong(held.last, held.middle);
    this.pulled.emit(held.last);
  }

  /** The handles stay with what they hold. */
  private goAlong({ kind, to, rise }: Pull, { x, y, z }: Vector3): void {
    this.group.position.set(...(kind === "move" ? to : ([x, y] as Point)), z + rise);
    this.stage.soon();
  }

  /** Whether it is the pointer, of several fingers, that holds a handle. */
  private isHolder(event: PointerEvent): boolean {
    return event.pointerId === this.held?.start.pointerId;
  }

  private end(phase: "up" | "cancel"): void {
    const last = this.held?.last;
    this.held = null;
    if (last) this.pulled.emit({ ...last, phase });
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
    const box = this.stage.canvas.getBoundingClientRect();
    const far = (knob: Knob): number => {
      const [x, y] = this.stage.onCanvas(this.placeOf(knob));
      return Math.hypot(x + box.left - event.clientX, y + box.top - event.clientY);
    };
    const near = event.pointerType === "touch" ? NEAR_FINGER : NEAR;
    const [nearest] = [...this.knobs].sort((a, b) => far(a) - far(b));
    return nearest && this.stage.isFree && far(nearest) <= near ? nearest : null;
  }
}

function knobsOf(grip: Grip): Knob[] {
  const ways = grip.axes.map((angle): Knob => {
    const way = direction(angle);
    return { kind: "move", place: new Vector3(...way, 0), way };
  });
  const knobs: Knob[] = ways.length > 1 ? [{ kind: "move", place: new Vector3() }, ...ways] : ways;
  if (grip.lift) knobs.push({ kind: "lift", place: new Vector3(0, 0, 1) });
  if (grip.heading !== null) knobs.push({ kind: "turn", place: new Vector3(...times(direction(grip.heading + 45), 0.7), 0) });
  return knobs;
}

/** The knobs, the lines to them, and the circle along which one turns. */
function drawn(grip: Grip, knobs: Knob[]): (Mesh | LineSegments)[] {
  const accent = color("--accent");
  const ink = { color: accent, depthTest: false, transparent: true };
  const lines = knobs.flatMap(({ kind, place }) => (kind === "turn" ? [] : [0, 0, 0, ...place.toArray()]));
  if (grip.heading !== null) lines.push(...circle(0.7));
  const parts: (Mesh | LineSegments)[] = knobs.map(({ kind, place }) => {
    const knob = new Mesh(new SphereGeometry(KNOB, 16, 12), new MeshBasicMaterial({ ...ink, color: kind === "turn" ? color("--seen") : accent }));
    knob.position.copy(place);
    return knob;
  });
  parts.push(new LineSegments(points(lines), new LineBasicMaterial(ink)));
  for (const part of parts) part.renderOrder = 4;
  return parts;
}

function circle(radius: number): number[] {
  const corner = (k: number): number[] => [...times(direction((360 * k) / ROUND), radius), 0];
  return Array.from({ length: ROUND }, (_, k) => [...corner(k), ...corner(k + 1)]).flat();
}
