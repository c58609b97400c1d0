/** Turning the view from outside with drag, wheel, two fingers and keys. */

import type { Outside } from "./protocol";

/** Degrees a pixel of drag, and a press of an arrow key. */
const TURN = 0.4;
const KEY_TURN = 5;
/** Factor of the distance for one notch of the wheel, and for + and -. */
const ZOOM = 1.1;
const LOWEST = -89;
const HIGHEST = -3;
const NEAREST = 0.3;
const FARTHEST = 1000;

/** Where to look from so that a whole plan is seen. */
export function overlook(bounds: [number, number, number, number]): Outside {
  const [left, low, right, high] = bounds;
  const size = Math.max(right - left, (high - low) * 1.3, 2);
  return {
    azimuth_deg: 90,
    elevation_deg: -55,
    distance: Math.min(size * 1.2, FARTHEST),
    at: [(left + right) / 2, (low + high) / 2],
  };
}

/** Lets an element turn a view; `changed` hears of each new one. */
export class Orbit {
  private readonly fingers = new Map<number, [number, number]>();

  constructor(
    private readonly element: HTMLElement,
    public view: Outside,
    private readonly changed: (view: Outside) => void,
  ) {
    element.tabIndex = 0;
    element.addEventListener("pointerdown", (event) => this.press(event));
    element.addEventListener("pointermove", (event) => this.drag(event));
    element.addEventListener("pointerup", (event) => this.release(event));
    element.addEventListener("pointercancel", (event) => this.release(event));
    element.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    element.addEventListener("keydown", (event) => this.key(event));
    element.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  /** Look from elsewhere, within what makes sense. */
  set(view: Outside): void {
    const azimuth = ((((view.azimuth_deg + 180) % 360) + 360) % 360) - 180;
    const elevation = Math.min(HIGHEST, Math.max(LOWEST, view.elevation_deg));
    this.view = {
      azimuth_deg: azimuth,
      elevation_deg: elevation,
      distance: Math.min(FARTHEST, Math.max(NEAREST, view.distance)),
      at: view.at,
    };
    this.changed(this.view);
  }

  private press(event: PointerEvent): void {
    this.element.setPointerCapture(event.pointerId);
    this.fingers.set(event.pointerId, [event.clientX, event.clientY]);
  }

  private release(event: PointerEvent): void {
    this.fingers.delete(event.pointerId);
  }

  private drag(event: PointerEvent): void {
    const before = this.fingers.get(event.pointerId);
    if (!before) return;
    const [dx, dy] = [event.clientX - before[0], event.clientY - before[1]];
    const apart = this.spread();
    this.fingers.set(event.pointerId, [event.clientX, event.clientY]);
    if (this.fingers.size > 1) {
      const now = this.spread();
      if (apart && now) this.set({ ...this.view, distance: (this.view.distance * apart) / now });
    } else if (event.shiftKey || event.buttons & 6) {
      this.shift(dx, dy);
    } else {
      this.turn(-dx * TURN, -dy * TURN);
    }
  }

  /** Distance of two fingers on the glass [px]. */
  private spread(): number {
    const [one, other] = [...this.fingers.values()];
    return one && other ? Math.hypot(one[0] - other[0], one[1] - other[1]) : 0;
  }

  private wheel(event: WheelEvent): void {
    event.preventDefault();
    const notches = event.deltaY / (event.deltaMode === WheelEvent.DOM_DELTA_PIXEL ? 100 : 3);
    this.set({ ...this.view, distance: this.view.distance * ZOOM ** notches });
  }

  private turn(azimuth: number, elevation: number): void {
    this.set({
      ...this.view,
      azimuth_deg: this.view.azimuth_deg + azimuth,
      elevation_deg: this.view.elevation_deg + elevation,
    });
  }

  /** Move the point that is looked at, as if the floor stuck to the pointer. */
  private shift(dx: number, dy: number): void {
    const scale = this.view.distance / Math.max(this.element.clientHeight, 1);
    const azimuth = (this.view.azimuth_deg * Math.PI) / 180;
    const [cos, sin] = [Math.cos(azimuth), Math.sin(azimuth)];
    const ahead = dy * scale;
    const aside = -dx * scale;
    const [x, y] = this.view.at;
    this.set({ ...this.view, at: [x + cos * ahead + sin * aside, y + sin * ahead - cos * aside] });
  }

  private key(event: KeyboardEvent): void {
    const turns: Record<string, [number, number]> = {
      ArrowLeft: [-KEY_TURN, 0],
      ArrowRight: [KEY_TURN, 0],
      ArrowUp: [0, -KEY_TURN],
      ArrowDown: [0, KEY_TURN],
    };
    const turn = turns[event.key];
    const zoom = { "+": 1 / ZOOM, "=": 1 / ZOOM, "-": ZOOM }[event.key];
    if (turn) this.turn(...turn);
    else if (zoom) this.set({ ...this.view, distance: this.view.distance * zoom });
    else return;
    event.preventDefault();
    event.stopPropagation();
  }
}
