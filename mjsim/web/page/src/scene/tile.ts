/** The view in 3-D among the views of Run and Review: a switch, and a tile while it is on. */

import { remembered, toggle } from "../run/controls";
import { makeTile, type Tile } from "../run/tile";
import { Door } from "./door";

export class SolidsTile {
  readonly door: Door;
  /** Puts the tile among the others. */
  readonly switch: HTMLButtonElement;
  private readonly tile: Tile;
  private key: unknown = null;

  constructor(
    /** Under which the switch is remembered. */
    kept: string,
    scene: () => Promise<ArrayBuffer>,
    /** Told when there are other tiles. */
    changed: () => void,
  ) {
    this.door = new Door(scene);
    this.tile = makeTile("scene", "3-D", this.door.element);
    const on = remembered(kept) === "yes";
    this.door.set(on, null);
    this.switch = toggle(
      { class: "quiet run-small", title: "View in 3-D" },
      on,
      (now) => {
        remembered(kept, now ? "yes" : "no");
        this.door.set(now, this.key);
        changed();
      },
      "3-D",
    );
  }

  tiles(): Tile[] {
    return this.door.isOpen ? [this.tile] : [];
  }

  /** Another scene is to be seen. */
  want(key: unknown): void {
    this.key = key;
    this.door.want(key);
  }
}
