/** Keeps the address of the page up to date, so that a reload, a bookmark, Back and Forward lead to what was shown. */

import { throttled } from "../signal";
import { addressOf, isSamePlace, type Place, placeAt } from "./address";

/**
 * What is shown is looked at so long after something was changed [ms]: opening a world changes the view, too, and
 * browsers refuse more than 200 addresses in 30 s.
 */
const SOON = 300;

export class Way {
  /** Call it when another place may be shown. */
  readonly changed = throttled(() => this.write(), SOON);
  /** Whether a place is being gone to: that is no new step. */
  private isGoing = true;

  constructor(
    private readonly now: () => Place,
    private readonly go: (place: Place) => Promise<void>,
  ) {
    window.addEventListener("popstate", () => void this.follow(() => this.go(placeAt(location.hash))));
  }

  /** Go to a place by a way that the address has already. */
  async follow(go: () => Promise<void>): Promise<void> {
    this.isGoing = true;
    try {
      await go();
    } finally {
      this.write();
      this.isGoing = false;
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
