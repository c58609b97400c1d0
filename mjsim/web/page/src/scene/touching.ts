/** Where bodies touch each other, as the last news of their places have it. */

import { Group, type Points } from "three";
import { color } from "../ui/theme";
import { points } from "./marks";
import { dots } from "./strokes";

/** Numbers of a contact: x, y, z [m], and whether it is with the floor. */
const ROW = 4;
/** Across a contact [m]; at least, and at least across one with the floor, of half the height of the view. */
const SIZE = 0.02;
const LARGE = 0.02;
const SMALL = 0.011;

export class Touching {
  readonly group = new Group();
  private readonly floor = mark("--muted", SMALL);
  private readonly others = mark("--touched", LARGE);

  constructor() {
    this.group.add(this.floor, this.others);
  }

  /** Draw contacts in the place of those before: the ones with the floor small. */
  show(contacts: Float32Array): void {
    const [others, floor]: [number[], number[]] = [[], []];
    for (let k = 0; k + ROW <= contacts.length; k += ROW)
      (contacts[k + 3] ? floor : others).push(...contacts.subarray(k, k + 3));
    place(this.others, others);
    place(this.floor, floor);
  }

  /** Take up the colours of the theme. */
  recolor(): void {
    this.floor.material.color.set(color("--muted"));
    this.others.material.color.set(color("--touched"));
  }
}

function mark(token: string, least: number): ReturnType<typeof dots> {
  const made = dots(points([]), SIZE, { color: color(token), through: true }, least);
  made.renderOrder = 4;
  made.visible = false;
  return made;
}

function place(shown: Points, numbers: number[]): void {
  shown.geometry.dispose();
  shown.geometry = points(numbers);
  shown.visible = numbers.length > 0;
}
