/** Sliders for the noise of a run while it goes on. */

import { el } from "../dom";
import { button, sign, write } from "./controls";
import type { Noise } from "./protocol";

/** The slider's way is cut into so many steps. */
const STEPS = 1000;
/** Where the slider ends when the world's own value is 0, by unit. */
const MOST: Record<string, number> = { deg: 10, m: 0.3, "m/s": 0.5 };

interface Row {
  noise: Noise;
  slider: HTMLInputElement;
  field: HTMLInputElement;
  reset: HTMLButtonElement;
}

/** A list of sliders, grouped by robot and sensor. */
export class NoisePanel {
  readonly element = el("div", { class: "noise" });
  private readonly rows = new Map<string, Row>();
  private readonly empty = el("p", { class: "hint" }, "Start a run; its noise can be changed here while it goes on.");
  private readonly all: HTMLButtonElement;

  constructor(private readonly set: (key: string, value: number) => void) {
    this.all = button({ class: "quiet" }, () => this.resetAll(), sign("restart"), "Reset all to the world's values");
    this.element.append(this.empty, this.all);
    this.all.hidden = true;
  }

  show(noise: Noise[], enabled: boolean): void {
    if (noise.map((each) => each.key).join() !== [...this.rows.keys()].join()) this.build(noise);
    for (const each of noise) this.refresh(each, enabled);
    this.empty.hidden = noise.length > 0;
    write(this.empty, enabled ? "Nothing in this run has noise that can be changed while it goes on." : this.hint());
    this.all.hidden = noise.length === 0;
    this.all.disabled = !enabled || noise.every((each) => each.value === each.initial);
  }

  private hint(): string {
    return "Start a run; its noise can be changed here while it goes on.";
  }

  private resetAll(): void {
    for (const { noise } of this.rows.values()) if (noise.value !== noise.initial) this.set(noise.key, noise.initial);
  }

  private build(noise: Noise[]): void {
    this.rows.clear();
    this.element.replaceChildren(this.empty);
    let group = "";
    for (const each of noise) {
      const [head, tail] = splitKey(each.key);
      if (head !== group) this.element.append(el("h3", {}, head));
      group = head;
      this.element.append(this.row(each, tail));
    }
    this.element.append(this.all);
  }

  private row(noise: Noise, label: string): HTMLElement {
    const most = mostOf(noise);
    // The square gives small values more room.
    const slider = el("input", { type: "range", min: 0, max: STEPS, step: 1, "data-key": noise.key, "aria-label": label });
    const field = el("input", { type: "number", min: 0, step: "any", "aria-label": `${label}, ${noise.unit ?? "value"}` });
    slider.addEventListener("input", () => this.set(noise.key, rounded(most * (Number(slider.value) / STEPS) ** 2)));
    field.addEventListener("change", () => {
      const value = Number(field.value);
      if (field.value !== "" && Number.isFinite(value) && value >= 0) this.set(noise.key, value);
      else field.value = String(noise.value);
    });
    const reset = button({ class: "quiet square", title: `Reset ${label} to ${noise.initial}` }, () => this.set(noise.key, noise.initial), sign("restart"));
    this.rows.set(noise.key, { noise, slider, field, reset });
    const unit = el("span", { class: "unit" }, noise.unit ?? "");
    return el(
      "div",
      { class: "noise-row", title: noise.description ?? undefined },
      el("span", { class: "noise-label" }, label),
      slider,
      el("span", { class: "noise-value" }, field, unit, reset),
    );
  }

  private refresh(noise: Noise, enabled: boolean): void {
    const row = this.rows.get(noise.key);
    if (!row) return;
    row.noise = noise;
    // What is being dragged or typed is left to the hand.
    if (document.activeElement !== row.slider) row.slider.value = String(STEPS * Math.sqrt(Math.min(1, noise.value / mostOf(noise))));
    if (document.activeElement !== row.field) row.field.value = String(rounded(noise.value));
    for (const each of [row.slider, row.field]) each.disabled = !enabled;
    row.reset.disabled = !enabled || noise.value === noise.initial;
  }
}

function mostOf({ initial, unit }: Noise): number {
  return initial > 0 ? Math.max(8 * initial, 0.01) : (MOST[unit ?? ""] ?? 0.2);
}

function rounded(value: number): number {
  return Number(value.toPrecision(3));
}

/** `robots.scout.odometry.noise.turn` -> `scout, odometry` and `turn`. */
function splitKey(key: string): [string, string] {
  const parts = key.split(".").filter((part, k) => part !== "noise" && part !== "sensors" && !(k === 0 && part === "robots"));
  return [parts.slice(0, -1).join(", "), (parts[parts.length - 1] ?? key).replace(/_deg$/, "").replaceAll("_", " ")];
}
