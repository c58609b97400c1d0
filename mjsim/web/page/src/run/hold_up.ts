/** What holds a robot up, such as a navigator that finds no way: told over the plan, for it is not looked for elsewhere. */

import type { EventNews } from "./protocol";

/** Events after which a robot does not go on. */
export const HOLD_UPS: readonly string[] = ["blocked", "lost", "fall", "fault"];
/** So long they are told [s of the simulation]. */
const TOLD = 10;

/** Whether an event still holds a robot up at a time [s]. */
export function holdsUp({ robot, time }: EventNews, chosen: string, now: number): boolean {
  return robot === chosen && now >= time && now - time < TOLD;
}
