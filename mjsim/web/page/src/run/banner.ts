/** The line above the views: that the server is away, or why a run failed. */

import { el } from "../ui/dom";
import { word } from "../words/words";
import type { LinkState } from "./link";

const OUT = word("run.mjsimWasStartedAnewAnd");
const LOST = word("run.theServerDoesNotAnswer");

export class Banner {
  readonly element = el("p", { class: "run-banner", role: "alert", hidden: true });
  private failed = false;

  /** Say that the server is away; hidden while it answers. */
  connection(state: LinkState, lost: boolean): void {
    this.element.hidden = !lost && state !== "out";
    this.element.textContent = state === "out" ? OUT : LOST;
  }

  /** Say why the run failed; null takes that away. */
  run(error: string | null): void {
    if (error === null && !this.failed) return;
    this.failed = error !== null;
    this.element.hidden = !this.failed;
    this.element.textContent = error ?? "";
  }

  /** Take away whatever stands here. */
  clear(): void {
    this.failed = false;
    this.element.hidden = true;
  }
}
