/** What happened, newest first. */

import { el } from "../ui/dom";
import { draw, html, repeat, type View } from "../ui/view";
import { said, word, wordOr } from "../words/words";
import { clock } from "./bar";
import type { EventNews } from "./protocol";

/** Most that are shown. */
const MOST = 300;

/** What happened, in one sentence that names its robot. */
export function sentenceOf({ robot, text }: EventNews): string {
  return !robot || text.includes(robot) ? said(text) : `${robot}: ${said(text)}`;
}

/** A list of events; each can be pressed where there is something to do. */
export class EventList {
  readonly element = el("div", { class: "run-events" });
  private events: EventNews[] = [];

  constructor(
    private readonly hint: string,
    private readonly pick?: (time: number) => void,
  ) {
    this.draw();
  }

  clear(): void {
    this.fill([]);
  }

  add(event: EventNews): void {
    this.take(event);
    this.draw();
  }

  fill(events: EventNews[]): void {
    this.events = [];
    for (const event of events) this.take(event);
    this.draw();
  }

  /** A motion may go on: what is told of it stands where it stood. */
  private take(event: EventNews): void {
    const before = event.motion === undefined ? -1 : this.events.findIndex(({ motion }) => motion === event.motion);
    if (before >= 0) this.events[before] = event;
    else this.events = [event, ...this.events].slice(0, MOST);
  }

  private draw(): void {
    const rows = repeat(
      this.events,
      (event) => event.motion ?? event,
      (event) => html`<li>${this.row(event)}</li>`,
    );
    const view = html`<p class="hint" ?hidden=${this.events.length > 0}>${this.hint}</p><ol aria-live="polite"
        aria-label=${word("run.eventsNewestFirst")}>${rows}</ol>`;
    draw(this.element, view);
  }

  private row(event: EventNews): View {
    const { pick } = this;
    const parts = html`<time>${clock(event.time)}</time><b data-event=${event.event}
      >${wordOr("event", event.event, event.event)}</b><span>${sentenceOf(event)}</span>`;
    return pick
      ? html`<button type="button" @click=${() => pick(event.time)}>${parts}</button>`
      : html`<div>${parts}</div>`;
  }
}
