/** The strip above a run: start, pause, speed, time. */

import { button, choice, write } from "../ui/controls";
import { el } from "../ui/dom";
import { icon } from "../ui/icons";
import { word } from "../words/words";
import type { LinkState } from "./link";
import type { RunNews, TickNews } from "./protocol";

const SPEEDS = [
  ["0.25", "¼ ×"],
  ["0.5", "½ ×"],
  ["1", "1 ×"],
  ["2", "2 ×"],
  ["4", "4 ×"],
  ["10", "10 ×"],
  ["max", "max"],
] as const;

type Speed = (typeof SPEEDS)[number][0];

const STATES: Record<RunNews["state"], string> = {
  idle: word("run.ready"),
  loading: word("run.loading"),
  running: word("run.running"),
  paused: word("run.paused"),
  ended: word("run.ended"),
  failed: word("run.failed"),
};

export interface BarOrders {
  start(): void;
  pause(): void;
  go(): void;
  tick(): void;
  restart(): void;
  stop(): void;
  speed(value: number | null): void;
}

/** Seconds as people read them. */
export function clock(seconds: number): string {
  // Rounded first: 59.999 s are a minute.
  const hundredths = Math.round(100 * seconds);
  if (hundredths < 6000) return `${(hundredths / 100).toFixed(2)} s`;
  return `${Math.floor(hundredths / 6000)}:${((hundredths % 6000) / 100).toFixed(2).padStart(5, "0")}`;
}

/** The strip; it shows what the server says and sends what is pressed. */
export class Bar {
  readonly element = el("div", { class: "run-bar", role: "toolbar", "aria-label": word("run.run") });
  private readonly main: HTMLButtonElement;
  private readonly step: HTMLButtonElement;
  private readonly again: HTMLButtonElement;
  private readonly halt: HTMLButtonElement;
  private readonly speeds: HTMLSelectElement;
  private readonly time = el("output", { class: "run-value run-time", title: word("run.simulatedTime") }, "–");
  private readonly pace = el("output", { class: "run-value", title: word("run.simulatedSecondsASecond") }, "–");
  private readonly pictures = el("output", { class: "run-value", title: word("run.picturesShownASecond") }, "–");
  private readonly status = el("span", { class: "run-state", role: "status" }, word("run.connecting"));
  /** What steers a run. */
  private readonly steering: HTMLElement[];
  private news: RunNews | null = null;
  private link: LinkState = "connecting";

  private canStart = false;

  constructor(
    private readonly orders: BarOrders,
    /** Whether runs are started here; else one is watched that was begun elsewhere. */
    private readonly starts: boolean,
  ) {
    this.main = button(
      { class: "primary run-main" },
      () => this.press(),
      icon("play"),
      el("span", {}, word("run.start")),
    );
    this.step = button({ class: "square", title: word("run.singleTick") }, () => orders.tick(), icon("step"));
    this.again = button(
      { class: "square", title: word("run.restartFromTheBeginning") },
      () => orders.restart(),
      icon("restart"),
    );
    this.halt = button({ class: "square", title: word("run.stopTheRun") }, () => orders.stop(), icon("stop"));
    this.speeds = choice<Speed>({ "aria-label": word("run.speed") }, SPEEDS, "1", (value) =>
      orders.speed(speedOf(value)),
    );
    const figure = (label: string, value: HTMLElement): HTMLElement =>
      el("label", { class: "run-figure" }, el("span", {}, label), value);
    this.steering = [
      el("div", { class: "run-group" }, this.step, this.again, this.halt),
      figure(word("run.speed"), this.speeds),
    ];
    this.element.append(
      this.main,
      ...this.steering,
      el("span", { class: "run-spring" }),
      figure(word("run.time"), this.time),
      figure(word("run.pace"), this.pace),
      figure(word("run.pictures"), this.pictures),
      this.status,
    );
    this.refresh();
  }

  /** The speed that is chosen; null for as fast as it goes. */
  get speed(): number | null {
    return speedOf(this.speeds.value as Speed);
  }

  /** Start, pause or go on, whichever makes sense now. */
  press(): void {
    if (this.main.disabled) return;
    const state = this.news?.state ?? "idle";
    if (state === "running") this.orders.pause();
    else if (state === "paused") this.orders.go();
    else this.orders.start();
  }

  /** Whether there is something to start from here. */
  offer(canStart: boolean): void {
    this.canStart = canStart;
    this.refresh();
  }

  connection(link: LinkState): void {
    this.link = link;
    this.refresh();
  }

  run(news: RunNews): void {
    this.news = news;
    const speed = news.speed === null ? "max" : String(news.speed);
    if (news.state !== "idle" && SPEEDS.some(([value]) => value === speed)) this.speeds.value = speed;
    this.showTime(news.time);
    if (news.state !== "running") write(this.pace, "–");
    this.refresh();
  }

  tick(news: TickNews): void {
    this.showTime(news.time);
    write(this.pace, news.pace > 0 ? `${news.pace.toFixed(2)} ×` : "–");
  }

  rate(pictures: number): void {
    write(this.pictures, pictures > 0 ? `${pictures.toFixed(pictures < 10 ? 1 : 0)} /s` : "–");
  }

  private showTime(time: number): void {
    const whole = this.news?.seconds;
    write(
      this.time,
      this.news?.state === "idle"
        ? "–"
        : !whole
          ? clock(time)
          : word("review.timeOf", { time: clock(time), whole: clock(whole).replace(".00", "") }),
    );
  }

  private refresh(): void {
    const state = this.news?.state ?? "idle";
    const open = this.link === "open";
    const mine = open && (this.news?.controllable ?? false);
    const alive = state === "running" || state === "paused";
    const label = state === "running" ? word("run.pause") : state === "paused" ? word("run.goOn") : word("run.start");
    this.main.replaceChildren(icon(state === "running" ? "pause" : "play"), el("span", {}, label));
    this.main.title = `${label} (space)`;
    this.main.disabled = !mine || state === "loading" || !(alive || this.canStart);
    this.step.disabled = !mine || state !== "paused";
    this.again.disabled = !mine || state === "idle" || state === "loading";
    this.halt.disabled = !mine || !(alive || state === "loading");
    this.speeds.disabled = !mine;
    // What can never be pressed here is not shown: a run that goes on elsewhere is watched, and not begun from here.
    const watched = this.news?.controllable === false;
    for (const each of this.steering) each.hidden = watched;
    this.main.hidden = watched || (!this.starts && !alive);
    const away: Record<LinkState, string> = {
      open: STATES[state],
      connecting: word("run.connecting"),
      closed: word("run.ended"),
      lost: word("run.serverLostTryingAgain"),
      out: word("run.notLetIn"),
    };
    const text = away[this.link];
    write(this.status, text);
    this.status.dataset.state = open ? state : this.link;
  }
}

function speedOf(value: Speed): number | null {
  return value === "max" ? null : Number(value);
}
