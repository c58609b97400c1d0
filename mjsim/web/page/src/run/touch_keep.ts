/** What was done by hand: it is written into the world's text, as its events, and what did not come of it is said. */

import type { Values } from "../api";
import { el, fill } from "../dom";
import type { Studio } from "../shell/view";
import { button } from "./controls";
import { Leader } from "./leader";
export type { TouchAnswer } from "./leader";
import type { RunNews, ShortNews, Touch as TouchRequest } from "./protocol";
import type { Toasts } from "../shell/toasts";
import type { Touch } from "./touch";
import type { Hands } from "./touch_tools";
import { word } from "../words/words";

/** A button above the list of events. */
export class Keep {
  readonly element: HTMLElement;
  private readonly keep = button({}, () => void this.write());
  private readonly note = el("p", { class: "hint" }, word("run.whatYouDidByHand"));
  private readonly head = el("div", { class: "run-keep", hidden: true }, this.keep, this.note);
  private run: RunNews | null = null;
  /** So many of the touches of this run stand in the text already. */
  private kept = 0;

  constructor(
    private readonly studio: Studio,
    list: HTMLElement,
  ) {
    this.element = el("div", {}, this.head, list);
  }

  show(run: RunNews): void {
    this.run = run;
    const touched = run.touched?.length ?? 0;
    if (touched < this.kept) this.kept = 0;
    const fresh = touched - this.kept;
    this.head.hidden = touched === 0 || this.studio.folder.mode === "live";
    this.keep.disabled = fresh === 0;
    fill(this.keep, fresh === 0 ? word("run.keptAsEvents") : fresh === 1 ? word("run.keepOneAsEvent") : word("run.keepAsEvents", { fresh }));
  }

  private async write(): Promise<void> {
    const { run } = this;
    const { document, toasts } = this.studio;
    const touched: Values[] = run?.touched ?? [];
    const fresh = touched.slice(this.kept);
    if (!run || fresh.length === 0) return;
    if (document.path !== run.path) return toasts.error(word("run.anotherWorldIsOpenOpen"));
    if (!(await document.change(fresh.map((value) => ({ op: "add", path: ["run", "events"], value }))))) return;
    this.kept = touched.length;
    this.show(run);
    toasts.done(fresh.length === 1 ? word("run.oneEventWasAdded") : word("run.eventsWereAdded", { count: fresh.length }));
  }
}

/** What a run tells of touches. */
interface Touched {
  isLive(): boolean;
  send(touch: TouchRequest): void;
  /** Where it is said what comes of them. */
  said(): { touch: Touch; hands: Hands; toasts: Toasts };
}

/** Sends touches of a run, and says what comes of them. */
export function leaderOf({ isLive, send, said }: Touched): Leader {
  return new Leader({
    isLive,
    send,
    refused: (error) => said().toasts.error(error),
    short: (news, dragged) => {
      const { touch, hands, toasts } = said();
      touch.staysAway(news);
      if (!dragged) toasts.done(shortSaid(news, hands));
    },
    reached: (event) => said().touch.reached(event),
  });
}

/** How far a hand of one of the people, or the tool of an arm, stays away from where it was led. */
function shortSaid({ of, part, metres }: ShortNews, people: Hands): string {
  const said = { of, part, metres: metres.toFixed(2) };
  if (!(of in people)) return word("run.toolStaysAway", said);
  return part === "left" ? word("run.leftHandStaysAway", said) : word("run.rightHandStaysAway", said);
}
