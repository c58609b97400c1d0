/** What was done by hand: it is written into the world's text, as its events, and what did not come of it is said. */

import type { Change, Values } from "../api";
import type { Studio } from "../shell/view";
import { button, write } from "../ui/controls";
import { el } from "../ui/dom";
import { Leader } from "./leader";

export type { TouchAnswer } from "./leader";

import type { Toasts } from "../shell/toasts";
import { said, word } from "../words/words";
import type { RunNews, ShortNews, Touch as TouchRequest } from "./protocol";
import type { Touch } from "./touch";
import type { Hands } from "./touch_tools";

/** A button above the list of events. */
export class Keep {
  readonly element: HTMLElement;
  private readonly keep = button({}, () => void this.write());
  private readonly note = el("p", { class: "hint" }, word("run.whatYouDidByHand"));
  private readonly head = el("div", { class: "run-keep", hidden: true }, this.keep, this.note);
  private run: RunNews | null = null;
  /** Touches of this run that stand in the text, as they were then: that of a drag may have gone on since. */
  private kept: Values[] = [];

  constructor(
    private readonly studio: Studio,
    list: HTMLElement,
  ) {
    this.element = el("div", {}, this.head, list);
  }

  show(run: RunNews): void {
    this.run = run;
    const touched: Values[] = run.touched ?? [];
    // Another run has other touches.
    if (!touched.some((event) => this.kept.some((before) => goesOn(before, event)))) this.kept = [];
    const fresh = this.fresh(touched).length;
    this.head.hidden = touched.length === 0 || this.studio.folder.mode === "live";
    this.keep.disabled = fresh === 0;
    const some = fresh === 1 ? word("run.keepOneAsEvent") : word("run.keepAsEvents", { fresh });
    write(this.keep, fresh === 0 ? word("run.keptAsEvents") : some);
  }

  /** Those that do not stand in the text as they are now, each with what stands there. */
  private fresh(touched: Values[]): [Values | undefined, Values][] {
    const found = touched.map((event): [Values | undefined, Values] => [
      this.kept.findLast((before) => goesOn(before, event)),
      event,
    ]);
    return found.filter(([before, event]) => JSON.stringify(before) !== JSON.stringify(event));
  }

  /** The change that writes an event: in the place of what a drag was when it was kept, or behind the others. */
  private change(before: Values | undefined, value: Values): Change {
    const events = (this.studio.document.parsed.run["events"] ?? []) as unknown[];
    const place = before ? events.findLastIndex((each) => goesOn(before, each)) : -1;
    return place < 0
      ? { op: "add", path: ["run", "events"], value }
      : { op: "set", path: ["run", "events", place], value };
  }

  private async write(): Promise<void> {
    const { run } = this;
    const { document, toasts } = this.studio;
    const touched: Values[] = run?.touched ?? [];
    const fresh = this.fresh(touched);
    if (!run || fresh.length === 0) return;
    if (document.path !== run.path) return toasts.error(word("run.anotherWorldIsOpenOpen"));
    await document.settled();
    if (!(await document.change(fresh.map(([before, event]) => this.change(before, event))))) return;
    this.kept = touched;
    this.show(run);
    toasts.done(
      fresh.length === 1 ? word("run.oneEventWasAdded") : word("run.eventsWereAdded", { count: fresh.length }),
    );
  }
}

/** Whether an event of the text is this one, perhaps with more targets; numbers are rounded there. */
function goesOn(event: Values, other: unknown): boolean {
  const rest = Object.entries(event).filter(([key]) => key !== "then");
  return (
    typeof other === "object" && other !== null && rest.every(([key, value]) => isAlike(value, (other as Values)[key]))
  );
}

function isAlike(one: unknown, other: unknown): boolean {
  if (Array.isArray(one))
    return Array.isArray(other) && one.length === other.length && one.every((each, k) => isAlike(each, other[k]));
  return typeof one === "number" && typeof other === "number" ? Math.abs(one - other) < 1e-3 : one === other;
}

/** What a run tells of touches. */
interface Touched {
  isLive(): boolean;
  send(touch: TouchRequest): void;
  /** Where it is said what comes of them. */
  told(): { touch: Touch; hands: Hands; toasts: Toasts };
}

/** Sends touches of a run, and says what comes of them. */
export function leaderOf({ isLive, send, told }: Touched): Leader {
  return new Leader({
    isLive,
    send,
    refused: (error) => told().toasts.error(said(error)),
    short: (news, dragged) => {
      const { touch, hands, toasts } = told();
      touch.staysAway(news);
      if (!dragged) toasts.done(shortSaid(news, hands));
    },
    reached: (event) => told().touch.reached(event),
  });
}

/** How far a hand of one of the people, or the tool of an arm, stays away from where it was led. */
function shortSaid({ of, part, metres }: ShortNews, people: Hands): string {
  const values = { of, part, metres: metres.toFixed(2) };
  if (!(of in people)) return word("run.toolStaysAway", values);
  return part === "left" ? word("run.leftHandStaysAway", values) : word("run.rightHandStaysAway", values);
}
