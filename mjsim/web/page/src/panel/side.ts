/** A mechanism or a person from aside, to scale, above the floor; what moves there is dragged. */

import type { Item, Point, Pose } from "../api";
import type { Poser } from "../edit/poser";
import { el } from "../ui/dom";
import { word } from "../words/words";

const SPACE = "http://www.w3.org/2000/svg";
/** Free paper around what is drawn, as a share of its size, and the least height of it [m]. */
const MARGIN = 0.08;
const LEAST = 0.5;
/** A drag begins after so many pixels. */
const THRESHOLD = 3;

export class SideDrawing {
  readonly element = el("div", { class: "side" });
  private readonly svg = document.createElementNS(SPACE, "svg");
  private readonly shapes = document.createElementNS(SPACE, "g");
  private readonly floor = document.createElementNS(SPACE, "line");
  private held: { pointer: number; part: string; from: Point; screen: Point; moved: boolean } | null = null;

  constructor(
    private readonly poser: Poser,
    private readonly subject: () => Item | null,
  ) {
    this.svg.setAttribute("role", "img");
    this.shapes.setAttribute("transform", "scale(1 -1)");
    this.floor.setAttribute("class", "side-floor");
    this.svg.append(this.floor, this.shapes);
    this.element.append(this.svg);
    this.svg.addEventListener("pointerdown", (event) => this.down(event));
    this.svg.addEventListener("pointermove", (event) => this.move(event));
    this.svg.addEventListener("pointerup", (event) => this.isHolder(event) && this.up());
    this.svg.addEventListener("pointercancel", (event) => this.isHolder(event) && this.cancel());
    window.addEventListener("keydown", (event) => event.key === "Escape" && this.cancel());
  }

  clear(): void {
    this.shapes.replaceChildren();
  }

  show(pose: Pose, subject: Item): void {
    this.svg.setAttribute(
      "aria-label",
      word(pose.look === "side" ? "panel.thingFromTheSide" : "panel.thingFromAhead", { thing: subject.label }),
    );
    // While something is dragged the paper stays where it is.
    if (!this.held) this.fit(pose);
    const chosen = this.poser.joint?.name;
    // A hand behind the body must be within reach, too.
    const parts = subject.kind === "person" ? [...pose.parts].sort((a, b) => rank(a) - rank(b)) : pose.parts;
    for (const shape of [...this.shapes.children].slice(parts.length)) shape.remove();
    parts.forEach(({ outline, pull, name }, k) => {
      const shape = this.polygon(k);
      shape.setAttribute("points", outline.map(([x, y]) => `${x},${y}`).join(" "));
      shape.setAttribute("data-name", name);
      if (pull && !subject.fixed) shape.setAttribute("data-pull", pull);
      else shape.removeAttribute("data-pull");
      shape.classList.toggle("chosen", Boolean(pull) && pull === chosen);
    });
  }

  /** The polygon of the k-th part: one that is there is kept, as the pointer may be on it. */
  private polygon(k: number): Element {
    const found = this.shapes.children[k];
    if (found) return found;
    return this.shapes.appendChild(document.createElementNS(SPACE, "polygon"));
  }

  private fit({ parts }: Pose): void {
    const points = parts.flatMap(({ outline }) => outline);
    const [xs, ys] = [points.map(([x]) => x), points.map(([, y]) => y)];
    const [left, right] = [Math.min(...xs), Math.max(...xs)];
    const [bottom, top] = [Math.min(...ys), Math.max(...ys)];
    // The floor is shown below what is not far above it.
    const size = Math.max(LEAST, right - left, top - bottom);
    const [low, high] = [bottom < size ? Math.min(0, bottom) : bottom, Math.max(bottom + LEAST, top)];
    const margin = MARGIN * Math.max(right - left, high - low);
    const [x, width] = [left - margin, right - left + 2 * margin];
    this.svg.setAttribute("viewBox", `${x} ${-high - margin} ${width} ${high - low + 2 * margin}`);
    for (const [key, value] of Object.entries({ x1: x - width, x2: x + 2 * width, y1: 0, y2: 0 }))
      this.floor.setAttribute(key, String(value));
  }

  /** A point of the page in metres of the drawing. */
  private place(event: PointerEvent): Point {
    const matrix = this.shapes.getScreenCTM();
    if (!matrix) return [0, 0];
    const { x, y } = new DOMPoint(event.clientX, event.clientY).matrixTransform(matrix.inverse());
    return [x, y];
  }

  private down(event: PointerEvent): void {
    const part = event.target instanceof SVGElement ? event.target.dataset["pull"] : undefined;
    if (!part || event.button !== 0 || !this.subject() || this.held) return;
    event.preventDefault();
    this.svg.setPointerCapture(event.pointerId);
    const { pointerId: pointer, clientX, clientY } = event;
    this.held = { pointer, part, from: this.place(event), screen: [clientX, clientY], moved: false };
  }

  private move(event: PointerEvent): void {
    const { held } = this;
    if (!held || !this.isHolder(event)) return;
    const [x, y] = held.screen;
    held.moved ||= Math.hypot(event.clientX - x, event.clientY - y) > THRESHOLD;
    const end = this.place(event);
    if (held.moved) this.poser.follow({ pull: { look: this.poser.look, part: held.part, start: held.from, end } });
  }

  /** Whether an event belongs to the pointer that drags. */
  private isHolder(event: PointerEvent): boolean {
    return event.pointerId === this.held?.pointer;
  }

  private up(): void {
    if (!this.held) return;
    this.held = null;
    void this.poser.keep();
  }

  private cancel(): void {
    if (!this.held) return;
    this.held = null;
    this.poser.forget();
  }
}

function rank({ pull }: Pose["parts"][number]): number {
  return pull ? 1 : 0;
}
