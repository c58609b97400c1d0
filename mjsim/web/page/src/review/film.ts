/** The marked part as a film: which view, how far it is, where it lies. */

import { ApiError } from "../api";
import { button } from "../ui/controls";
import { el } from "../ui/dom";
import { icon } from "../ui/icons";
import { draw, html, options, repeat, type View } from "../ui/view";
import { said, word } from "../words/words";
import type { Looked } from "./looked";
import { type Recording, recordings } from "./recording";

/** The server is asked how far it is so often [ms]. */
const ASK = 400;

interface Job {
  title: string;
  /** How far it is, and then what came of it. */
  state: View;
}

export class Film {
  readonly element = el("div", { class: "run-film" });
  private readonly views = el("select", { "aria-label": word("review.viewOfTheVideo") });
  private readonly start: HTMLButtonElement;
  private readonly what = el("p", { class: "hint" });
  private readonly progress = el("div", { class: "run-film-jobs", "aria-live": "polite" });
  /** The newest first. */
  private readonly jobs: Job[] = [];

  constructor(private readonly looked: Looked) {
    this.start = button({ class: "primary" }, () => void this.make(), icon("film"), word("review.exportVideo"));
    this.element.append(
      this.what,
      el("label", { class: "run-field" }, el("span", {}, word("review.view")), this.views),
      this.start,
      this.progress,
    );
    this.start.disabled = true;
  }

  load({ cameras, views = ["plan", "chase", "overview", ...cameras] }: Recording): void {
    draw(
      this.views,
      options(
        views.map((view) => [view, titleOf(view)] as const),
        views[0] ?? "",
      ),
    );
    this.start.disabled = false;
  }

  mark(): void {
    const [from, to] = this.looked.ends;
    const length = word("review.fromTo", { from: from.toFixed(2), to: to.toFixed(2) });
    this.what.textContent = this.looked.isWhole
      ? word("review.theWholeRecordingMarkA", { length })
      : word("review.theMarkedPart", { length });
  }

  private async make(): Promise<void> {
    const { recording, ends } = this.looked;
    if (!recording) return;
    const [from, to] = ends;
    const view = this.views.value;
    const job: Job = { title: `${titleOf(view)}, ${(to - from).toFixed(1)} s`, state: progress(0, 1) };
    this.jobs.unshift(job);
    this.show(job, job.state);
    this.progress.firstElementChild?.scrollIntoView({ block: "nearest" });
    try {
      const path = await this.follow((await recordings.film(recording.path, from, to, view)).job, job);
      const name = path.split("/").pop() ?? "video.mp4";
      this.show(job, html`<a href=${recordings.file(path)} download=${name}>${path}</a>`);
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      this.show(job, html`<span class="run-problem">${error.message}</span>`);
    }
  }

  private show(job: Job, state: View): void {
    job.state = state;
    const row = (each: Job): View => html`<div class="run-film-job"><span>${each.title}</span>${each.state}</div>`;
    draw(
      this.progress,
      repeat(this.jobs, (each) => each, row),
    );
  }

  /** Wait until it is done and return where it lies. */
  private async follow(id: string, job: Job): Promise<string> {
    for (;;) {
      const { error, path, total, done } = await recordings.job(id);
      if (error) throw new ApiError(500, said(error));
      if (path) return path;
      this.show(job, progress(done, total));
      await new Promise((done) => setTimeout(done, ASK));
    }
  }
}

function progress(done: number, total: number): View {
  return html`<progress .max=${Math.max(total, 1)} .value=${done} aria-label=${word("review.progress")}></progress>`;
}

export function titleOf(view: string): string {
  const titles: Record<string, string> = {
    plan: word("review.plan"),
    frame: word("review.planCloseUpCameraErrors"),
    chase: word("review.behindTheRobot"),
    overview: word("review.fromAbove"),
    outside: word("review.outside"),
  };
  return titles[view] ?? view.replace("/", " · ").replace(":", ", ");
}
