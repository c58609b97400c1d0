/** The directions of x, y and z as the view has them, in a corner of it. */

import { type Camera, Quaternion } from "three";
import { setAttributes } from "../ui/dom";
import { endsOf } from "./frame";

/** Length of an axis, and half of the size of the picture [px]. */
const LENGTH = 22;
const HALF = 34;
const SPACE = "http://www.w3.org/2000/svg";

export class Axes {
  readonly element = document.createElementNS(SPACE, "svg");
  private readonly arms = ["x", "y", "z"].map((name) => {
    const [line, text] = [document.createElementNS(SPACE, "line"), document.createElementNS(SPACE, "text")];
    text.textContent = name;
    const arm = document.createElementNS(SPACE, "g");
    arm.setAttribute("data-axis", name);
    arm.append(line, text);
    return { arm, line, text };
  });

  constructor() {
    setAttributes(this.element, {
      class: "scene-axes",
      viewBox: `${-HALF} ${-HALF} ${2 * HALF} ${2 * HALF}`,
      "aria-hidden": "true",
    });
    this.element.append(...this.arms.map(({ arm }) => arm));
  }

  /** Turn them as a camera sees them. */
  show(eye: Camera): void {
    const { x, y, z, w } = eye.getWorldQuaternion(new Quaternion());
    const ends = endsOf([w, x, y, z]);
    // What is nearer is drawn over the others.
    const order = [...this.arms.keys()].sort((a, b) => (ends[a]?.[2] ?? 0) - (ends[b]?.[2] ?? 0));
    for (const k of order) {
      const [right = 0, down = 0] = (ends[k] ?? []).map((part) => LENGTH * part);
      const { arm, line, text } = this.arms[k] ?? {};
      if (!arm || !line || !text) continue;
      setAttributes(line, { x2: right.toFixed(1), y2: down.toFixed(1) });
      setAttributes(text, { x: (1.35 * right).toFixed(1), y: (1.35 * down).toFixed(1) });
      this.element.append(arm);
    }
  }
}
