/** The bar to go through a recording: events stand on it, and the part that is marked. */

import { sentenceOf } from "../run/events";
import type { EventNews } from "../run/protocol";
import { el } from "../ui/dom";
import { draw, html, type View } from "../ui/view";
import { word } from "../words/words";
import type { Part } from "./looked";

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
    draw(
      this.flags,
      events.map((event) => this.flag(event)),
    );
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

  private flag(news: EventNews): View {
    const { time, event } = news;
    const title = `${time.toFixed(2)} s  ${sentenceOf(news)}`;
    return html`<button type="button" tabindex="-1" title=${title} aria-label=${title} data-event=${event}
      style="left: ${this.share(time)}" @click=${() => this.seek(time)}></button>`;
  }

  private share(time: number): string {
    return `${(100 * time) / this.seconds}%`;
  }
}
