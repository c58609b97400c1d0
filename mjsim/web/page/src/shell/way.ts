/** Keeps the address of the page up to date, so that a reload, a bookmark, Back and Forward lead to what was shown. */

import { throttled } from "../ui/signal";
import { addressOf, isSamePlace, type Place, placeAt } from "./address";

/**
 * What is shown is looked at so long after something was changed [ms]: opening a world changes the view, too, and
 * browsers refuse more than 200 addresses in 30 s.
 */
const SOON = 300;

export class Way {
  /** Call it when another place may be shown. */
  readonly changed = throttled(() => {
    // On the way the address is already that of the place gone to.
    if (!this.isGoing) this.write();
  }, SOON);
  /** Whether a place is being gone to: that is no new step. */
  private isGoing = true;
  private last: Promise<void> = Promise.resolve();
  private turn = 0;

  constructor(
    private readonly now: () => Place,
    private readonly go: (place: Place) => Promise<void>,
  ) {
    window.addEventListener("popstate", () => void this.follow(() => this.go(placeAt(location.hash))));
  }

  /**
   * Go to a place by a way that the address has already, once those before are gone: two at once would write each
   * other's address, and take away the steps forward. Of several that wait only the last is gone.
   */
  async follow(go: () => Promise<void>): Promise<void> {
    const turn = ++this.turn;
    this.isGoing = true;
    const run = async (): Promise<void> => {
      if (turn === this.turn) await go();
    };
    const mine = this.last.then(run, run);
    this.last = mine;
    try {
      await mine;
    } finally {
      if (turn === this.turn) {
        this.write();
        this.isGoing = false;
      }
    }
  }

  private write(): void {
    const place = this.now();
    const address = addressOf(place);
    if (address === location.hash) return;
    if (this.isGoing || isSamePlace(place, placeAt(location.hash))) history.replaceState(null, "", address);
    else history.pushState(null, "", address);
  }
}
