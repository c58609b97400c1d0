/** Sliders for the noise of a run while it goes on. */

import { button, write } from "../ui/controls";
import { el } from "../ui/dom";
import { icon } from "../ui/icons";
import { meaningOf, word, wordFor } from "../words/words";
import type { NoiseFigure } from "./protocol";

/** The slider's way is cut into so many steps. */
const STEPS = 1000;
/** Where the slider ends when the world's own value is 0 and the model says nothing, by unit. */
const MOST: Record<string, number> = { deg: 10, m: 0.3, "1/s": 2 };

/** Values at the ends of a slider; `even` unless small values get more room. */
interface Span {
  low: number;
  high: number;
  even: boolean;
}

interface Row {
  noise: NoiseFigure;
  slider: HTMLInputElement;
  field: HTMLInputElement;
  reset: HTMLButtonElement;
}

/** A list of sliders, grouped by robot and sensor. */
export class NoisePanel {
  readonly element = el("div", { class: "run-noise" });
  private readonly rows = new Map<string, Row>();
  private readonly empty = el("p", { class: "hint" }, word("run.startARunItsNoise"));
  private readonly all: HTMLButtonElement;

  constructor(private readonly set: (key: string, value: number) => void) {
    this.all = button({ class: "quiet" }, () => this.resetAll(), icon("restart"), word("run.resetAllToTheWorld"));
    this.element.append(this.empty, this.all);
    this.all.hidden = true;
  }

  show(noise: NoiseFigure[], enabled: boolean): void {
    if (noise.map((each) => each.key).join() !== [...this.rows.keys()].join()) this.build(noise);
    for (const each of noise) this.refresh(each, enabled);
    this.empty.hidden = noise.length > 0;
    write(this.empty, enabled ? word("run.nothingInThisRunHas") : this.hint());
    this.all.hidden = noise.length === 0;
    this.all.disabled = !enabled || noise.every((each) => each.value === each.initial);
  }

  private hint(): string {
    return word("run.startARunItsNoise");
  }

  private resetAll(): void {
    for (const { noise } of this.rows.values())
      if (noise.value !== noise.initial) this.set(noise.key, noise.initial ?? 0);
  }

  private build(noise: NoiseFigure[]): void {
    this.rows.clear();
    this.element.replaceChildren(this.empty);
    let group = "";
    for (const each of noise) {
      const [head, tail] = splitKey(each.key);
      if (head !== group) this.element.append(el("h2", {}, head));
      group = head;
      this.element.append(this.row(each, tail));
    }
    this.element.append(this.all);
  }

  private row(noise: NoiseFigure, label: string): HTMLElement {
    const span = spanOf(noise);
    const slider = el("input", {
      type: "range",
      min: 0,
      max: STEPS,
      step: 1,
      "data-key": noise.key,
      "aria-label": label,
    });
    const field = el("input", {
      type: "number",
      min: span.even ? null : 0,
      step: "any",
      "aria-label": `${label}, ${noise.unit ?? word("run.value")}`,
    });
    // Each value that is set is an event: one, where the slider is let go, not one for each step of its way.
    const shown = (): number => valueAt(span, Number(slider.value) / STEPS);
    slider.addEventListener("input", () => (field.value = String(shown())));
    slider.addEventListener("change", () => this.set(noise.key, shown()));
    field.addEventListener("change", () => {
      const value = Number(field.value);
      if (field.value !== "" && Number.isFinite(value) && (span.even || value >= 0)) this.set(noise.key, value);
      else field.value = String(rounded(this.rows.get(noise.key)?.noise.value ?? 0));
    });
    const reset = button(
      { class: "quiet square", title: word("run.resetTo", { label, initial: noise.initial ?? 0 }) },
      () => this.set(noise.key, noise.initial ?? 0),
      icon("restart"),
    );
    this.rows.set(noise.key, { noise, slider, field, reset });
    const unit = el("span", { class: "run-unit" }, unitShown(noise));
    return el(
      "div",
      { class: "run-noise-row", title: noise.description ? meaningOf(noise.description) : undefined },
      el("span", { class: "run-noise-label" }, label),
      slider,
      el("span", { class: "run-noise-value" }, field, unit, reset),
    );
  }

  private refresh(noise: NoiseFigure, enabled: boolean): void {
    const row = this.rows.get(noise.key);
    if (!row) return;
    row.noise = noise;
    // What is being dragged or typed is left to the hand.
    if (document.activeElement !== row.slider)
      row.slider.value = String(STEPS * shareOf(spanOf(noise), noise.value ?? 0));
    if (document.activeElement !== row.field) row.field.value = String(rounded(noise.value ?? 0));
    for (const each of [row.slider, row.field]) each.disabled = !enabled;
    row.reset.disabled = !enabled || noise.value === noise.initial;
  }
}

function spanOf({ initial, unit, slider }: NoiseFigure): Span {
  const [low, high] = [slider?.[0] ?? 0, slider?.[1] ?? MOST[unit ?? ""] ?? 0.2];
  // An error to both sides of a value, or a probability.
  if (low !== 0 || (slider && high === 1)) return { low, high, even: low !== 0 };
  return { low, high: initial ? 8 * initial : high, even: false };
}

/** The value at a share of the slider's way; the square gives small values more room. */
function valueAt({ low, high, even }: Span, share: number): number {
  return rounded(low + (high - low) * (even ? share : share ** 2));
}

function shareOf({ low, high, even }: Span, value: number): number {
  const share = Math.min(1, Math.max(0, (value - low) / (high - low)));
  return even ? share : Math.sqrt(share);
}

function rounded(value: number): number {
  return Number(value.toPrecision(3));
}

/** `robots.scout.odometry.noise.turn` -> `scout, odometry` and `turn`. */
function splitKey(key: string): [string, string] {
  const parts = key.split(".");
  const last = wordFor("field", (parts.pop() ?? key).replace(/_deg$/, "")).toLowerCase();
  const group = parts.filter((part, k) => part !== "noise" && part !== "sensors" && !(k === 0 && part === "robots"));
  return [group.join(", "), last];
}

function unitShown({ unit }: NoiseFigure): string {
  return unit?.replace(/sqrt\((\w+)\)/, "√$1") ?? "";
}
