/** The strip above a run: start, pause, speed, time. */

import { el } from "../ui/dom";
import { iconButton, sign } from "../ui/icons";
import { choice, draw, html, type View } from "../ui/view";
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
  private news: RunNews | null = null;
  private link: LinkState = "connecting";
  private canStart = false;
  private chosen: Speed = "1";
  /** Simulated time [s], simulated seconds a second, and pictures shown a second. */
  private figures = { time: 0, pace: 0, pictures: 0 };

  constructor(
    private readonly orders: BarOrders,
    /** Whether runs are started here; else one is watched that was begun elsewhere. */
    private readonly starts: boolean,
  ) {
    this.draw();
  }

  /** The speed that is chosen; null for as fast as it goes. */
  get speed(): number | null {
    return speedOf(this.chosen);
  }

  private get state(): RunNews["state"] {
    return this.news?.state ?? "idle";
  }

  /** Whether the run takes orders from here. */
  private get isMine(): boolean {
    return this.link === "open" && (this.news?.controllable ?? false);
  }

  private get isAlive(): boolean {
    return this.state === "running" || this.state === "paused";
  }

  private get canPress(): boolean {
    return this.isMine && this.state !== "loading" && (this.isAlive || this.canStart);
  }

  /** Start, pause or go on, whichever makes sense now. */
  press(): void {
    if (!this.canPress) return;
    if (this.state === "running") this.orders.pause();
    else if (this.state === "paused") this.orders.go();
    else this.orders.start();
  }

  /** Whether there is something to start from here. */
  offer(canStart: boolean): void {
    this.canStart = canStart;
    this.draw();
  }

  connection(link: LinkState): void {
    this.link = link;
    this.draw();
  }

  run(news: RunNews): void {
    this.news = news;
    const speed = news.speed === null ? "max" : String(news.speed);
    if (news.state !== "idle") this.chosen = SPEEDS.find(([value]) => value === speed)?.[0] ?? this.chosen;
    this.figures.time = news.time;
    if (news.state !== "running") this.figures.pace = 0;
    this.draw();
  }

  tick({ time, pace }: TickNews): void {
    Object.assign(this.figures, { time, pace });
    this.draw();
  }

  rate(pictures: number): void {
    this.figures.pictures = pictures;
    this.draw();
  }

  private draw(): void {
    const { state, orders, isMine, isAlive } = this;
    const label = word(state === "running" ? "run.pause" : state === "paused" ? "run.goOn" : "run.start");
    // What can never be pressed here is not shown: a run that goes on elsewhere is watched, and not begun from here.
    const watched = this.news?.controllable === false;
    const begun = isAlive || state === "loading";
    const canRestart = state !== "idle" && state !== "loading";
    const choose = (speed: Speed): void => {
      this.chosen = speed;
      orders.speed(this.speed);
    };
    const view = html`<button type="button" class="primary run-main" title="${label} (space)" ?disabled=${!this.canPress}
          ?hidden=${watched || (!this.starts && !isAlive)} @click=${() => this.press()}
          >${sign(state === "running" ? "pause" : "play")}<span>${label}</span></button>
        <div class="run-group" ?hidden=${watched}>
          ${iconButton("step", word("run.singleTick"), orders.tick, !isMine || state !== "paused", "")}
          ${iconButton("restart", word("run.restartFromTheBeginning"), orders.restart, !isMine || !canRestart, "")}
          ${iconButton("stop", word("run.stopTheRun"), orders.stop, !isMine || !begun, "")}</div>
        <label class="run-figure" ?hidden=${watched}><span>${word("run.speed")}</span>${choice(word("run.speed"), SPEEDS, this.chosen, choose, !isMine)}</label>
        <span class="run-spring"></span>${this.shownFigures()}${this.status()}`;
    draw(this.element, view);
  }

  private shownFigures(): View {
    const { time, pace, pictures } = this.figures;
    const whole = this.news?.seconds;
    const timed = whole
      ? word("review.timeOf", { time: clock(time), whole: clock(whole).replace(".00", "") })
      : clock(time);
    const rate = pictures > 0 ? `${pictures.toFixed(pictures < 10 ? 1 : 0)} /s` : "–";
    return [
      figure(word("run.time"), word("run.simulatedTime"), this.state !== "idle" ? timed : "–", "run-time"),
      figure(word("run.pace"), word("run.simulatedSecondsASecond"), pace > 0 ? `${pace.toFixed(2)} ×` : "–"),
      figure(word("run.pictures"), word("run.picturesShownASecond"), rate),
    ];
  }

  private status(): View {
    const away: Record<LinkState, string> = {
      open: STATES[this.state],
      connecting: word("run.connecting"),
      closed: word("run.ended"),
      lost: word("run.serverLostTryingAgain"),
      out: word("run.notLetIn"),
    };
    const told = this.link === "open" ? this.state : this.link;
    return html`<span class="run-state" role="status" data-state=${told}>${away[this.link]}</span>`;
  }
}

function figure(label: string, title: string, value: string, kind = ""): View {
  return html`<label class="run-figure"><span>${label}</span><output class="run-value ${kind}" title=${title}>${value}</output></label>`;
}

function speedOf(value: Speed): number | null {
  return value === "max" ? null : Number(value);
}
