/** What the address of the page says after its #: the view, the world and, in Review, the recording and its time. */

export interface Place {
  view: string;
  /** Path of the world; null for none, or one without a file. */
  world: string | null;
  recording: string | null;
  /** Time of the recording [s]. */
  time: number;
}

/** Return the end of the address that names a place. */
export function addressOf({ view, world, recording, time }: Place): string {
  const said = new URLSearchParams();
  if (world) said.set("world", world);
  if (recording) said.set("recording", recording);
  if (recording && time) said.set("time", String(Math.round(100 * time) / 100));
  // Slashes and colons are allowed there, and people read them.
  const more = said.toString().replaceAll("%2F", "/").replaceAll("%3A", ":");
  return `#${view}${more && `?${more}`}`;
}

/** Return the place that the end of an address names; what cannot be read is left out. */
export function placeAt(address: string): Place {
  const [view = "", more = ""] = address.replace(/^#/, "").split(/\?(.*)/s);
  const said = new URLSearchParams(more);
  const time = Number(said.get("time"));
  const [world, recording] = [said.get("world") || null, said.get("recording") || null];
  return { view, world, recording, time: Number.isFinite(time) ? time : 0 };
}

/** Whether only the time differs: that is no step back. */
export function isSamePlace(one: Place, other: Place): boolean {
  return addressOf({ ...one, time: 0 }) === addressOf({ ...other, time: 0 });
}
