/** Where metres lie on the screen: x to the right and y up in the world, y down in pixels. */

import type { Bounds, Point } from "../api";

/** A kilometre on a small plan, and a millimetre on a large one [px/m]. */
export const SMALLEST = 0.1;
export const LARGEST = 4000;

export class PlanView {
  /** [px/m] */
  scale = 60;
  /** Where the world's origin lies [px]. */
  left = 60;
  top = 400;
  width = 0;
  height = 0;

  toScreen([x, y]: Point): Point {
    return [this.left + x * this.scale, this.top - y * this.scale];
  }

  toWorld([x, y]: Point): Point {
    return [(x - this.left) / this.scale, (this.top - y) / this.scale];
  }

  /** What is seen of the world [m]. */
  get bounds(): Bounds {
    const [x0, y0] = this.toWorld([0, this.height]);
    const [x1, y1] = this.toWorld([this.width, 0]);
    return [x0, y0, x1, y1];
  }

  /** Zoom so that the point of the world at a pixel stays there. */
  zoom(factor: number, [x, y]: Point): void {
    const before = this.toWorld([x, y]);
    this.scale = Math.min(Math.max(this.scale * factor, SMALLEST), LARGEST);
    this.left = x - before[0] * this.scale;
    this.top = y + before[1] * this.scale;
  }

  /** Show all of a part of the world, with free paper around it [px]. */
  fit([x0, y0, x1, y1]: Bounds, margin: number): void {
    const wide = Math.max(this.width - 2 * margin, 40);
    const high = Math.max(this.height - 2 * margin, 40);
    const scale = Math.min(wide / Math.max(x1 - x0, 0.5), high / Math.max(y1 - y0, 0.5), 250);
    this.scale = Math.max(scale, SMALLEST);
    this.centre([(x0 + x1) / 2, (y0 + y1) / 2]);
  }

  /** Bring a point of the world to the middle. */
  centre([x, y]: Point): void {
    this.left = this.width / 2 - x * this.scale;
    this.top = this.height / 2 + y * this.scale;
  }
}

/** The round length, 1, 2 or 5 times a power of ten, that is at least so many pixels [m]. */
export function roundStep(scale: number, pixels: number): number {
  const least = pixels / scale;
  const power = 10 ** Math.floor(Math.log10(least));
  return power * ([1, 2, 5, 10].find((times) => times * power >= least * 0.999) ?? 10);
}

/** A length as on a ruler: no more decimals than its step needs. */
export function metres(value: number, step: number): string {
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  return (Math.abs(value) < step / 2 ? 0 : value).toFixed(digits).replace("-", "−");
}
