/** Sliders for the noise of a run while it goes on. */

import { el } from "../ui/dom";
import { iconButton, sign } from "../ui/icons";
import { draw, html, nothing, repeat, unheld, type View, withNumber } from "../ui/view";
import { meaningOf, word, wordFor } from "../words/words";
import { rounded, shareOf, spanOf, splitKey, valueAt } from "./noise_scale";
import type { NoiseFigure } from "./protocol";

/** The slider's way is cut into so many steps. */
const STEPS = 1000;

/** A list of sliders, grouped by robot and sensor. */
export class NoisePanel {
  readonly element = el("div", { class: "run-noise" });
  private noise: NoiseFigure[] = [];
  private enabled = false;
  /** What is dragged, and where it is. */
  private dragged: { key: string; value: number } | null = null;

  constructor(private readonly set: (key: string, value: number) => void) {
    this.draw();
  }

  show(noise: NoiseFigure[], enabled: boolean): void {
    Object.assign(this, { noise, enabled });
    this.draw();
  }

  private draw(): void {
    const { noise, enabled } = this;
    const hint = html`<p class="hint">${word(enabled ? "run.nothingInThisRunHas" : "run.startARunItsNoise")}</p>`;
    const isAsWritten = noise.every(({ value, initial }) => value === initial);
    const all = html`<button type="button" class="quiet" ?disabled=${!enabled || isAsWritten} @click=${() => this.resetAll()}
      >${sign("restart")}${word("run.resetAllToTheWorld")}</button>`;
    let group = "";
    const row = (each: NoiseFigure): View => {
      const [head, tail] = splitKey(each.key);
      const begins = head !== group;
      group = head;
      return [begins ? html`<h2>${head}</h2>` : nothing, this.row(each, wordFor("field", tail).toLowerCase())];
    };
    const rows = repeat(noise, ({ key }) => key, row);
    draw(this.element, noise.length ? html`${rows}${all}` : hint);
  }

  private resetAll(): void {
    for (const { key, value, initial } of this.noise) if (value !== initial) this.set(key, initial ?? 0);
  }

  private row(noise: NoiseFigure, label: string): View {
    const { key, value, initial, unit, description } = noise;
    const span = spanOf(noise);
    const isOff = !this.enabled;
    const at = (place: number): number => valueAt(span, place / STEPS);
    const slide = (place: number): void => {
      this.dragged = { key, value: at(place) };
      this.draw();
    };
    // Each value that is set is an event: one, where the slider is let go, not one for each step of its way.
    const end = (place: number): void => {
      this.dragged = null;
      this.set(key, at(place));
    };
    const text = String(this.dragged?.key === key ? this.dragged.value : rounded(value ?? 0));
    const enter = ({ target }: Event): void => {
      const field = target as HTMLInputElement;
      const entered = field.valueAsNumber;
      if (Number.isFinite(entered) && (span.even || entered >= 0)) this.set(key, entered);
      else field.value = text;
    };
    const title = word("run.resetTo", { label, initial: initial ?? 0 });
    const reset = iconButton("restart", title, () => this.set(key, initial ?? 0), isOff || value === initial);
    return html`<div class="run-noise-row" title=${description ? meaningOf(description) : nothing}>
      <span class="run-noise-label">${label}</span>
      <input type="range" min="0" max=${STEPS} step="1" data-key=${key} aria-label=${label} ?disabled=${isOff}
        .value=${unheld(String(Math.round(STEPS * shareOf(span, value ?? 0))))} @input=${withNumber(slide)} @change=${withNumber(end)}>
      <span class="run-noise-value"><input type="number" min=${span.even ? nothing : 0} step="any" ?disabled=${isOff}
        aria-label="${label}, ${unit ?? word("run.value")}" .value=${unheld(text)} @change=${enter}><span
        class="run-unit">${unitShown(noise)}</span>${reset}</span></div>`;
  }
}

function unitShown({ unit }: NoiseFigure): string {
  return unit?.replace(/sqrt\((\w+)\)/, "√$1") ?? "";
}
