/** The world and robots of a recording. */

export interface RecordingCard {
  path: string;
  /** When it was written [s since 1970]. */
  when: number;
  bytes: number;
  /** '' for what is no recording of mjsim. */
  world: string;
  robots: string[];
  /** null: its end is missing. */
  seconds: number | null;
}

/** Date, length, world and robots, as far as they are known. */
export function factsOf({ when, seconds, world, robots }: RecordingCard): string[] {
  return [dateOf(new Date(1000 * when)), seconds === null ? "" : lengthOf(seconds), world, robots.join(", ")].filter(
    Boolean,
  );
}

/** Recordings that are there, the newest first as far as that is known. */
export function newestFirst(cards: RecordingCard[], there: string[]): string[] {
  const known = cards.map(({ path }) => path).filter((path) => there.includes(path));
  return [...new Set([...known, ...there])];
}

/** Whether the name, folder, date, world or robots of a recording have all words that are searched for. */
export function isFound(wish: string, path: string, facts: string[]): boolean {
  const text = [path, ...facts].join(" ").toLowerCase();
  return wish
    .toLowerCase()
    .split(/\s+/)
    .every((part) => text.includes(part));
}

/** As ISO 8601 has it, in the time of this place: it reads the same in all languages. */
function dateOf(date: Date): string {
  const two = (number: number): string => String(number).padStart(2, "0");
  const day = [date.getFullYear(), two(date.getMonth() + 1), two(date.getDate())].join("-");
  return `${day} ${two(date.getHours())}:${two(date.getMinutes())}`;
}

function lengthOf(seconds: number): string {
  const whole = Math.round(seconds);
  if (seconds < 10) return `${seconds.toFixed(1)} s`;
  return whole < 60 ? `${whole} s` : `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")}`;
}
