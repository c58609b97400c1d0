/** The marked part as a film: which view, how far it is, where it lies. */

import { ApiError } from "../api";
import { button } from "../ui/controls";
import { el, fill } from "../ui/dom";
import { icon } from "../ui/icons";
import { said, word } from "../words/words";
import { type Recording, recordings } from "./recording";

/** The server is asked how far it is so often [ms]. */
const ASK = 400;

export class Film {
  readonly element = el("div", { class: "run-film" });
  private readonly views = el("select", { "aria-label": word("review.viewOfTheVideo") });
  private readonly start: HTMLButtonElement;
  private readonly what = el("p", { class: "hint" });
  private readonly progress = el("div", { class: "run-film-jobs", "aria-live": "polite" });
  private recording: Recording | null = null;
  private part: [number, number] = [0, 0];

  constructor() {
    this.start = button({ class: "primary" }, () => void this.make(), icon("film"), word("review.exportVideo"));
    this.element.append(
      this.what,
      el("label", { class: "run-field" }, el("span", {}, word("review.view")), this.views),
      this.start,
      this.progress,
    );
    this.start.disabled = true;
  }

  load(recording: Recording): void {
    this.recording = recording;
    const views = recording.views ?? ["plan", "chase", "overview", ...recording.cameras];
    fill(this.views, ...views.map((view) => el("option", { value: view }, titleOf(view))));
    this.start.disabled = false;
    this.mark(0, recording.seconds, false);
  }

  mark(from: number, to: number, marked: boolean): void {
    this.part = [from, to];
    const length = word("review.fromTo", { from: from.toFixed(2), to: to.toFixed(2) });
    this.what.textContent = marked
      ? word("review.theMarkedPart", { length })
      : word("review.theWholeRecordingMarkA", { length });
  }

  private async make(): Promise<void> {
    if (!this.recording) return;
    const [from, to] = this.part;
    const view = this.views.value;
    const bar = el("progress", { max: 1, value: 0, "aria-label": word("review.progress") });
    const note = el("span", {}, `${titleOf(view)}, ${(to - from).toFixed(1)} s`);
    const row = el("div", { class: "run-film-job" }, note, bar);
    this.progress.prepend(row);
    row.scrollIntoView({ block: "nearest" });
    try {
      const { job } = await recordings.film(this.recording.path, from, to, view);
      const path = await this.follow(job, bar);
      fill(row, note, el("a", { href: recordings.file(path), download: path.split("/").pop() ?? "video.mp4" }, path));
      row.scrollIntoView({ block: "nearest" });
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      fill(row, note, el("span", { class: "run-problem" }, error.message));
    }
  }

  /** Wait until it is done and return where it lies. */
  private async follow(id: string, bar: HTMLProgressElement): Promise<string> {
    for (;;) {
      const job = await recordings.job(id);
      if (job.error) throw new ApiError(500, said(job.error));
      if (job.path) return job.path;
      bar.max = Math.max(job.total, 1);
      bar.value = job.done;
      await new Promise((done) => setTimeout(done, ASK));
    }
  }
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
