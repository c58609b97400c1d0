/** Values of joints as people read them: degrees and metres. */

import type { JointFacts } from "./protocol";

export function unit({ slides }: JointFacts): string {
  return slides ? "m" : "°";
}

/** Radians or metres for one of what is shown. */
export function scale({ slides }: JointFacts): number {
  return slides ? 1 : Math.PI / 180;
}

export function shown(facts: JointFacts, value: number): number {
  return value / scale(facts);
}

/** To so many decimals that a limit stays within it [deg, m]. */
export function rounded(value: number): number {
  return Math.round(value * 1e5) / 1e5;
}

/** A value that a drag gives, in degrees or metres: no finer than a hand is, unless it is at a limit. */
export function dragged(facts: JointFacts, value: number): number {
  const parts = facts.slides ? 1e4 : 1e2;
  const coarse = Math.round(shown(facts, value) * parts) / parts;
  const there = coarse * scale(facts);
  const within = there >= (facts.lower ?? there) && there <= (facts.upper ?? there);
  return within ? coarse : rounded(shown(facts, value));
}
