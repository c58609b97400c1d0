/** Drags on the floor of a view in 3-D, while goals are set there. */

import { MOUSE, TOUCH } from "three";
import type { Point } from "../api";
import { Signal } from "../ui/signal";
import type { Stage3d } from "./stage";

export class Aim {
  /** From where to where the floor was dragged [m]. */
  readonly told = new Signal<[from: Point, to: Point]>();
  private isOn = false;
  private from: Point | null = null;

  constructor(private readonly stage: Stage3d) {
    const { canvas } = stage;
    canvas.addEventListener(
      "pointerdown",
      (event) => (this.from = event.button || !this.isOn ? null : this.onFloor(event)),
    );
    canvas.addEventListener("pointerup", (event) => {
      const [from, to] = [this.from, this.onFloor(event)];
      this.from = null;
      if (from && to) this.told.emit([from, to]);
    });
    canvas.addEventListener("pointercancel", () => (this.from = null));
  }

  /** Aim, or let drags turn the view again. */
  set(on: boolean): void {
    this.isOn = on;
    this.stage.controls.mouseButtons.LEFT = on ? null : MOUSE.ROTATE;
    this.stage.controls.touches.ONE = on ? null : TOUCH.ROTATE;
    this.stage.canvas.style.cursor = on ? "crosshair" : "";
  }

  /** Nothing where a robot's camera looks. */
  private onFloor({ clientX, clientY }: PointerEvent): Point | null {
    const place = this.stage.isFree ? this.stage.onLevel(clientX, clientY, 0) : null;
    return place && [place.x, place.y];
  }
}
