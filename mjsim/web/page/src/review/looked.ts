/** What is looked at in Review: the one place that says which recording, which time, and which part of it. */

import type { TickNews } from "../run/protocol";
import { Player } from "./player";
import type { Recording } from "./recording";

/** A marked part [s]; null at an end that is not marked yet. */
export interface Part {
  from: number | null;
  to: number | null;
}

export const UNMARKED: Part = { from: null, to: null };

export class Looked {
  readonly player = new Player();
  recording: Recording | null = null;
  /** Its last tick that came: it may be of a time that was looked at before. */
  tick: TickNews | null = null;
  part = UNMARKED;
  /** The robot whose charts are shown. */
  robot = "";

  get time(): number {
    return this.player.time;
  }

  /** Whether nothing is marked. */
  get isWhole(): boolean {
    return this.part.from === null && this.part.to === null;
  }

  /** Begin and end of what is marked, or of all [s]. */
  get ends(): [number, number] {
    return [this.part.from ?? 0, this.part.to ?? this.recording?.seconds ?? 0];
  }

  /** When something happened [s]. */
  get events(): number[] {
    return (this.recording?.events ?? []).map(({ time }) => time);
  }

  /** The part from now on; an end that is before that goes. */
  fromNow(): Part {
    const { to } = this.part;
    return { from: this.time, to: to !== null && to > this.time ? to : null };
  }

  untilNow(): Part {
    const { from } = this.part;
    return { from: from !== null && from < this.time ? from : null, to: this.time };
  }
}
