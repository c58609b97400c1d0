/** What happened, newest first. */

import { button } from "../ui/controls";
import { el } from "../ui/dom";
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
  /** Rows of motions that may go on, by number. */
  private readonly motions = new Map<number, HTMLElement>();
  private readonly list = el("ol", { "aria-label": word("run.eventsNewestFirst") });
  private readonly empty: HTMLElement;

  constructor(
    hint: string,
    private readonly pick?: (time: number) => void,
  ) {
    this.list.setAttribute("aria-live", "polite");
    this.empty = el("p", { class: "hint" }, hint);
    this.element.append(this.empty, this.list);
  }

  clear(): void {
    this.list.replaceChildren();
    this.motions.clear();
    this.empty.hidden = false;
  }

  add(event: EventNews): void {
    this.empty.hidden = true;
    const parts = [
      el("time", {}, clock(event.time)),
      el("b", { "data-event": event.event }, wordOr("event", event.event, event.event)),
      el("span", {}, sentenceOf(event)),
    ];
    const pick = this.pick;
    const row = pick ? button({}, () => pick(event.time), ...parts) : el("div", {}, ...parts);
    const item = el("li", {}, row);
    const before = event.motion === undefined ? undefined : this.motions.get(event.motion);
    if (event.motion !== undefined) this.motions.set(event.motion, item);
    if (before) return before.replaceWith(item);
    this.list.prepend(item);
    while (this.list.childElementCount > MOST) this.list.lastElementChild?.remove();
  }

  fill(events: EventNews[]): void {
    this.clear();
    for (const event of events) this.add(event);
  }
}
