/** Rows of joints that are led by hand: a slider, and a field with its unit. */

import { html, nothing, unheld, type View, withNumber } from "../ui/view";
import { shown, unit } from "./joint_units";
import type { JointFacts } from "./protocol";

/** How far sliders of joints without limits go, of those that turn and of those that slide [rad, m]. */
const FREE = [Math.PI, 1] as const;

export interface Led {
  label: string;
  title?: string;
  /** Where it is [rad, m]; not known before somebody tells. */
  at: number | undefined;
  /** What its slider leaves out of that [rad, m]. */
  turns?: number;
  enabled: boolean;
  /** Where its slider is dragged, and where it is let go [rad, m]. */
  slide(to: number): void;
  end(to: number): void;
  /** What is entered [deg, m]; a field that is left empty is filled by the next tick. */
  enter(value: number): void;
  more?: View;
}

export function jointRow(
  facts: JointFacts,
  { label, title, at, turns = 0, enabled, slide, end, enter, more }: Led,
): View {
  const free = FREE[facts.slides ? 1 : 0];
  const [low, high] = [facts.lower ?? (facts.period ? 0 : -free), facts.upper ?? facts.period ?? free];
  const [slider, field] = at === undefined ? ["", ""] : [String(at - turns), shown(facts, at).toFixed(2)];
  return html`<div class="run-noise-row" title=${title ?? nothing}><span class="run-noise-label">${label}</span>
    <input type="range" min=${low} max=${high} step="any" aria-label=${facts.name} ?disabled=${!enabled}
      .value=${unheld(slider)} @input=${withNumber(slide)} @change=${withNumber(end)}>
    <span class="run-noise-value"><input type="number" step="any" aria-label="${facts.name}, ${unit(facts)}"
      ?disabled=${!enabled} .value=${unheld(field)} @change=${withNumber(enter)}><span class="run-unit">${unit(facts)}</span
      >${more}</span></div>`;
}
