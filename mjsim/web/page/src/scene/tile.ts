/** The view in 3-D among the views of Run and Review: a switch, and a tile while it is on. */

import { remembered, toggle } from "../ui/controls";
import { el } from "../ui/dom";
import { makeTile, type Tile } from "../ui/tile";
import { draw, html } from "../ui/view";
import { word } from "../words/words";
import { Door } from "./door";

export class SolidsTile {
  readonly door: Door;
  /** Puts the tile among the others. */
  readonly switch: HTMLButtonElement;
  /** Menus may stand here, in the head of the tile. */
  readonly menus = el("span", { class: "scene-menus" });
  private readonly tile: Tile;
  /** Stands in the place of the view while there is no scene yet, or it is too slow for a run. */
  private readonly rest = el("div", { class: "scene-rest", role: "status", hidden: true });
  private on: boolean;
  private key: unknown = null;

  constructor(
    /** Under which the switch is remembered. */
    private readonly kept: string,
    scene: () => Promise<ArrayBuffer>,
    /** Told when there are other tiles. */
    changed: () => void,
    /** Whether it goes off where it is slow, until it is wanted nonetheless. */
    { yields = false } = {},
  ) {
    this.door = new Door(scene);
    this.tile = makeTile(
      "scene",
      word("scene.bar"),
      el("div", { class: "scene-place" }, this.door.element, this.rest),
      this.menus,
    );
    this.on = remembered(kept) === "yes";
    this.show(this.on);
    const set = (now: boolean): void => {
      remembered(kept, now ? "yes" : "no");
      this.show(now);
      changed();
    };
    this.switch = toggle({ class: "quiet run-small", title: word("scene.viewIn3d") }, this.on, set, word("scene.bar"));
    if (yields) this.door.slow.on((rate) => this.yield(rate));
  }

  tiles(): Tile[] {
    return this.on ? [this.tile] : [];
  }

  /** Another scene is to be seen. */
  want(key: unknown, world: string): void {
    const isFirst = this.key === null;
    this.key = key;
    if (isFirst) this.show(this.on);
    this.door.want(key, world);
  }

  private show(on: boolean): void {
    this.on = on;
    const waits = on && this.key === null;
    if (waits) draw(this.rest, html`<p class="hint">${word("scene.comesWithARun")}</p>`);
    this.rest.hidden = !waits;
    this.door.element.hidden = waits;
    this.door.set(on, this.key);
  }

  /** Go off, say so, and stay off the next time, unless it is wanted however slow. */
  private yield(rate: number): void {
    const wanted = `${this.kept}.slow`;
    if (!this.on || remembered(wanted) === "yes") return;
    remembered(this.kept, "no");
    this.door.set(false, null);
    this.door.element.hidden = true;
    const nonetheless = (): void => {
      remembered(wanted, "yes");
      remembered(this.kept, "yes");
      this.show(true);
    };
    const said = word("scene.tooSlow", { rate: rate.toFixed(rate < 10 ? 1 : 0) });
    const view = html`<p class="hint">${said}</p><button type="button" @click=${nonetheless}>${word("scene.showItNonetheless")}</button>`;
    draw(this.rest, view);
    this.rest.hidden = false;
  }
}
