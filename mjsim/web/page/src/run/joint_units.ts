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
