/** The bar to go through a recording: events stand on it, and the part that is marked. */

import { sentenceOf } from "../run/events";
import type { EventNews } from "../run/protocol";
import { el, fill } from "../ui/dom";
import { word } from "../words/words";

export interface Part {
  from: number | null;
  to: number | null;
}

export class Scrub {
  readonly element = el("div", { class: "run-scrub" });
  private readonly range = el("input", {
    type: "range",
    min: 0,
    max: 1,
    step: "any",
    "aria-label": word("review.time"),
  });
  private readonly band = el("div", { class: "run-scrub-part", hidden: true });
  private readonly flags = el("div", { class: "run-scrub-events" });
  private seconds = 1;

  constructor(private readonly seek: (time: number) => void) {
    this.range.addEventListener("input", () => this.seek(Number(this.range.value)));
    this.element.append(el("div", { class: "run-scrub-way" }, this.band, this.flags), this.range);
  }

  load(seconds: number, dt: number, events: EventNews[]): void {
    this.seconds = Math.max(seconds, dt);
    this.range.max = String(seconds);
    this.range.step = String(dt);
    fill(this.flags, ...events.map((event) => this.flag(event)));
  }

  show(time: number): void {
    this.range.value = String(time);
    this.range.setAttribute("aria-valuetext", word("review.seconds", { time: time.toFixed(2) }));
  }

  mark({ from, to }: Part): void {
    this.band.hidden = from === null && to === null;
    const [left, right] = [from ?? to ?? 0, to ?? from ?? 0];
    this.band.style.left = this.share(left);
    this.band.style.width = `max(2px, ${(100 * (right - left)) / this.seconds}%)`;
  }

  private flag(event: EventNews): HTMLElement {
    const title = `${event.time.toFixed(2)} s  ${sentenceOf(event)}`;
    return el("button", {
      type: "button",
      tabindex: -1,
      title,
      "aria-label": title,
      "data-event": event.event,
      style: `left: ${this.share(event.time)}`,
      onclick: () => this.seek(event.time),
    });
  }

  private share(time: number): string {
    return `${(100 * time) / this.seconds}%`;
  }
}
