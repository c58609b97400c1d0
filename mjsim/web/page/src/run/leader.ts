/** Sends what is done to a run by hand. What is dragged is led while the drag goes on: to the newest target, none queued. */

import type { Values } from "../api";
import type { RefusedNews, ShortNews, Touch, TouchedNews } from "./protocol";

/** Targets of a drag are sent at most this often [ms]. */
const EVERY = 80;

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
export const NOBODY: Telling = {
  isLive: () => false,
  send: nothing,
  refused: nothing,
  short: nothing,
  reached: nothing,
};

interface Sent {
  event: Values;
  /** Whether more targets of the same drag may come. */
  dragged: boolean;
}

/** What the server says to a touch that it took. */
export type TouchAnswer = TouchedNews | ShortNews;
type Answer = TouchAnswer | RefusedNews;

export class Leader {
  /** What was sent and is not answered yet, in order. */
  private sent: Sent[] = [];
  private next: Values | null = null;
  /** The last target of the drag that was sent. */
  private last = "";
  /** The run has taken a target of the drag. */
  private taken = false;
  /** It was let go, and its last target waits. */
  private ends = false;
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
    // Something else was let go just now.
    if (this.ends) this.finish();
    this.next = event;
    this.go();
  }

  /** It is let go there. */
  end(event: Values): void {
    if (!this.leads) {
      this.touch(event);
      return this.drop();
    }
    [this.next, this.ends] = [event, true];
    // Whether it goes on with a motion is known once the target before is answered.
    if (!this.isWaiting) this.finish();
  }

  /** It is led no more; it stays where it was led to. */
  drop(): void {
    window.clearTimeout(this.timer);
    this.sent = this.sent.map(({ event }) => ({ event, dragged: false }));
    [this.next, this.last, this.taken, this.ends, this.timer, this.trouble] = [null, "", false, false, 0, null];
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
    if (this.ends) this.finish();
    else this.go();
  }

  private get isWaiting(): boolean {
    return this.sent.some(({ dragged }) => dragged);
  }

  /** Send the last target, unless it is there already; then say what came of it. */
  private finish(): void {
    const { next, trouble } = this;
    if (next && JSON.stringify(next) !== this.last) this.sendNext(next, false);
    else if (next && trouble) this.report(trouble, next);
    this.drop();
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
    if (!next || this.ends || JSON.stringify(next) === this.last || this.isWaiting) return;
    const wait = this.at + EVERY - performance.now();
    if (wait <= 0) this.sendNext(next, true);
    else this.timer = window.setTimeout(() => this.go(), wait);
  }

  private sendNext(event: Values, dragged: boolean): void {
    this.sent.push({ event, dragged });
    this.telling.send({ do: "touch", event, drag: this.taken ? "next" : "first" });
    this.next = null;
    this.last = JSON.stringify(event);
    this.at = performance.now();
  }
}
