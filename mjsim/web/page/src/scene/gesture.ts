/** A press on a handle in 3-D that becomes a drag: before the view is turned by it, by one pointer, given up with Escape. */

import {
  type Group,
  type LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshBasicMaterial,
  SphereGeometry,
  type Vector3,
} from "three";
import type { Stage3d } from "./stage";

/** How long a handle is, as a share of how far away the thing is. */
const REACH = 0.13;
/** A knob, as a share of that. */
const KNOB = 0.09;
/** A knob is met within so many pixels; by a finger within more. */
const NEAR = 12;
const NEAR_FINGER = 24;
/** A press that moves less than this drags nothing [px]. */
const STILL = 3;

/** What has handles. */
export interface Owner {
  /** Whether a press takes a handle. */
  take(event: PointerEvent): boolean;
  /** The handle that is held goes on; not called before the pointer has moved clearly. */
  drag(event: PointerEvent): void;
  /** It is let go, or given up. */
  end(done: boolean): void;
  /** A pointer that holds nothing passes, with no button down. */
  hover(event: PointerEvent): void;
}

export class Gesture {
  /** The press by which a handle is held. */
  private start: PointerEvent | null = null;
  private moving = false;

  constructor(
    private readonly stage: Stage3d,
    private readonly owner: Owner,
  ) {
    this.listen("pointerdown", (event) => this.down(event));
    this.listen("pointermove", (event) => this.move(event));
    this.listen("pointerup", (event) => this.isHolder(event) && this.end(true));
    this.listen("pointercancel", (event) => this.isHolder(event) && this.end(false));
    const giveUp = (event: KeyboardEvent): void => {
      if (event.key !== "Escape" || !this.start) return;
      event.stopImmediatePropagation();
      this.end(false);
    };
    window.addEventListener("keydown", giveUp, true);
  }

  /** Let go of what is held, as if Escape were pressed. */
  giveUp(): void {
    if (this.start) this.end(false);
  }

  private listen(
    kind: "pointerdown" | "pointermove" | "pointerup" | "pointercancel",
    heard: (event: PointerEvent) => void,
  ): void {
    const { canvas } = this.stage;
    // Before the view itself is turned by the same press.
    const first = (event: PointerEvent): void => {
      const was = this.start;
      heard(event);
      if (was || this.start) event.stopImmediatePropagation();
    };
    canvas.addEventListener(kind, first, true);
  }

  private down(event: PointerEvent): void {
    if (event.button || this.start || !this.owner.take(event)) return;
    [this.start, this.moving] = [event, false];
    this.stage.canvas.setPointerCapture(event.pointerId);
    this.stage.canvas.focus();
  }

  private move(event: PointerEvent): void {
    if (!this.start) {
      if (!event.buttons) this.owner.hover(event);
      return;
    }
    if (!this.isHolder(event)) return;
    this.moving ||= Math.hypot(event.clientX - this.start.clientX, event.clientY - this.start.clientY) > STILL;
    if (this.moving) this.owner.drag(event);
  }

  private end(done: boolean): void {
    this.start = null;
    this.owner.end(done);
  }

  /** Whether it is the pointer, of several fingers, that holds a handle. */
  private isHolder(event: PointerEvent): boolean {
    return event.pointerId === this.start?.pointerId;
  }
}

/** How long handles at a place are [m]: as long on the page however far away it is. */
export function handleLength({ orbit }: Stage3d, place: Vector3): number {
  return Math.max(REACH * orbit.position.distanceTo(place), 1e-3);
}

/** The knobs that a pointer meets, the nearest first; none while the view is not looked at freely. */
export function knobsNear<K>(stage: Stage3d, event: PointerEvent, knobs: K[], placeOf: (knob: K) => Vector3): K[] {
  if (!stage.isFree) return [];
  const { left, top } = stage.canvas.getBoundingClientRect();
  const near = event.pointerType === "touch" ? NEAR_FINGER : NEAR;
  return knobs
    .map((knob) => {
      const [x, y] = stage.onCanvas(placeOf(knob));
      return { knob, far: Math.hypot(x + left - event.clientX, y + top - event.clientY) };
    })
    .filter(({ far }) => far <= near)
    .sort((a, b) => a.far - b.far)
    .map(({ knob }) => knob);
}

/** A knob at a place in units of the handles' length, so many times as large as usual. */
export function knobMesh(place: Vector3, ink: ConstructorParameters<typeof MeshBasicMaterial>[0], size = 1): Mesh {
  const knob = new Mesh(new SphereGeometry(size * KNOB, 16, 12), new MeshBasicMaterial(ink));
  knob.position.copy(place);
  return knob;
}

/** How handles are drawn: over everything. */
export function inkOf(color: string): { color: string; depthTest: boolean; transparent: boolean } {
  return { color, depthTest: false, transparent: true };
}

/** Let handles be drawn after the scene. */
export function inFront(group: Group, ...parts: (Mesh | LineSegments)[]): Group {
  for (const part of parts) part.renderOrder = 4;
  return group.add(...parts);
}

/** Take all handles out of a group, and give back what they hold. */
export function clearHandles(group: Group): void {
  group.traverse((part) => {
    if (!(part instanceof Mesh || part instanceof LineSegments)) return;
    (part as Mesh).geometry.dispose();
    ((part as Mesh).material as MeshBasicMaterial | LineBasicMaterial).dispose();
  });
  group.clear();
}
