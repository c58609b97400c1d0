/** Which run is shown, and what is chosen and done in it. */

import { HOLD_UPS, holdsUp } from "./hold_up";
import type { EventNews, RobotFacts, RunNews } from "./protocol";

/** What is open to be run. */
export interface Opened {
  path: string | null;
  isOpen: boolean;
  hasFile: boolean;
}

export class Current {
  run: RunNews | null = null;
  /** The robot that is watched and driven. */
  chosen = "";
  /** Whether a hand has driven it. */
  driven = false;
  /** Whether the run that the server tells of is of another world than the one that is open. */
  other = false;
  /** The last event of which a robot does not go on. */
  private holdUp: EventNews | null = null;
  private readonly live: boolean;
  private readonly opened: Opened;

  /** @param live whether the page shows one run alone, which was begun elsewhere */
  constructor(live: boolean, opened: Opened) {
    this.live = live;
    this.opened = opened;
  }

  get robot(): RobotFacts | null {
    return this.run?.robots.find(({ name }) => name === this.chosen) ?? null;
  }

  /** Whether it has begun and has not ended. */
  get isOn(): boolean {
    return this.run?.state === "running" || this.run?.state === "paused";
  }

  get isControllable(): boolean {
    return this.isOn && (this.run?.controllable ?? false);
  }

  get canDrive(): boolean {
    return this.isControllable && (this.robot?.can_drive ?? false);
  }

  /** Another world was opened. */
  leave(): void {
    const { path, hasFile } = this.opened;
    this.other = !this.live && !(hasFile && this.run?.path === path);
  }

  /** The run as it is shown: nothing has run yet where one of another world is over. */
  own(news: RunNews): RunNews {
    const { path, isOpen } = this.opened;
    if (!this.run) this.other = !this.live && isOpen && news.path !== path;
    else if (this.isAnother(news)) this.other = this.driven = false;
    const over = news.state === "ended" || news.state === "failed";
    return this.other && over
      ? { ...news, state: "idle", time: 0, error: null, recording: null, robots: [], mechanisms: [] }
      : news;
  }

  /** Whether it is another run than before, or begins again; that it loads may not have been told. */
  isAnother(news: RunNews): boolean {
    const begins = news.state === "loading" && this.run?.state !== "loading";
    return begins || news.number !== this.run?.number;
  }

  event(news: EventNews): void {
    if (HOLD_UPS.includes(news.event)) this.holdUp = news;
  }

  forgetEvents(): void {
    this.holdUp = null;
  }

  /** Why the robot does not go on at a time of the run [s]. */
  heldUp(time: number): EventNews | null {
    return this.holdUp && holdsUp(this.holdUp, this.chosen, time) ? this.holdUp : null;
  }
}
