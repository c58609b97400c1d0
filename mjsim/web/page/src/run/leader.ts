/** Sends what is done to a run by hand. What is dragged is led while the drag goes on: to the newest target, none queued. */

import type { Values } from "../api";
import type { RefusedNews, ShortNews, Touch, TouchedNews } from "./protocol";

/** Targets of a drag are sent at most this often [ms]. */
const EVERY = 80;
/** An answer that takes longer than this does not come any more [ms]. */
const LOST = 3000;

export interface Telling {
  /** Whether what is dragged can follow: the run goes on. */
  isLive(): boolean;
  send(touch: Touch): void;
  refused(error: string): void;
  /** A hand or a tool does not reach its target; while it is dragged, or at the end. */
  short(news: ShortNews, dragged: boolean): void;
  /** What was touched reaches its target. */
  reached(event: Values): void;
}

const nothing = (): undefined => undefined;
/** Where there is no run to touch. */
export const NOBODY: Telling = { isLive: () => false, send: nothing, refused: nothing, short: nothing, reached: nothing };

interface Sent {
  event: Values;
  /** Whether more targets of the same drag may come. */
  dragged: boolean;
}

type Answer = TouchedNews | ShortNews | RefusedNews;

export class Leader {
  /** What was sent and is not answered yet, in order. */
  private sent: Sent[] = [];
  private next: Values | null = null;
  /** The last target of the drag that was sent. */
  private last = "";
  /** The run has taken a target of the drag. */
  private taken = false;
  private timer = 0;
  private at = 0;
  /** What the last answer of the drag said, unless it was taken. */
  private trouble: Answer | null = null;

  constructor(private readonly telling: Telling) {}

  /** Whether targets of a drag were sent. */
  get leads(): boolean {
    return this.last !== "";
  }

  /** Do one thing. */
  touch(event: Values): void {
    this.sent.push({ event, dragged: false });
    this.telling.send({ do: "touch", event });
  }

  /** What is dragged is to be there now. */
  lead(event: Values): void {
    if (!this.telling.isLive()) return;
    this.next = event;
    this.go();
  }

  /** It is let go there. */
  end(event: Values): void {
    const led = this.leads;
    const differs = JSON.stringify(event) !== this.last;
    if (!led) this.touch(event);
    else if (differs) this.sendNext(event, false);
    else if (this.trouble && !this.sent.length) this.report(this.trouble, event);
    this.drop();
  }

  /** It is led no more; it stays where it was led to. */
  drop(): void {
    window.clearTimeout(this.timer);
    this.sent = this.sent.map(({ event }) => ({ event, dragged: false }));
    [this.next, this.last, this.taken, this.timer, this.trouble] = [null, "", false, 0, null];
  }

  /** Nothing that was sent will be answered. */
  forget(): void {
    this.drop();
    this.sent = [];
  }

  answered(answer: Answer): void {
    const first = this.sent.shift();
    if (!first) return answer.kind === "refused" ? this.telling.refused(answer.error) : undefined;
    this.report(answer, first.event, first.dragged);
    if (!first.dragged) return;
    this.taken ||= answer.kind !== "refused";
    this.trouble = answer.kind === "touched" ? null : answer;
    this.go();
  }

  private report(answer: Answer, event: Values, dragged = false): void {
    if (answer.kind === "short") this.telling.short(answer, dragged);
    else if (answer.kind === "touched") this.telling.reached(event);
    else if (!dragged) this.telling.refused(answer.error);
  }

  /** Send the newest target once the one before is answered and it is time. */
  private go(): void {
    window.clearTimeout(this.timer);
    const { next } = this;
    if (!next || JSON.stringify(next) === this.last) return;
    const now = performance.now();
    const due = this.at + (this.sent.length ? LOST : EVERY);
    if (now >= due) {
      if (this.sent.length) this.sent = [];
      this.sendNext(next, true);
    } else this.timer = window.setTimeout(() => this.go(), due - now);
  }

  private sendNext(event: Values, dragged: boolean): void {
    this.sent.push({ event, dragged });
    this.telling.send({ do: "touch", event, drag: this.taken ? "next" : "first" });
    this.next = null;
    this.last = JSON.stringify(event);
    this.at = performance.now();
  }
}
