/** What to do next, in a word over the large view of a run. */

import { el, fill } from "../dom";
import { button } from "./controls";
import type { RunNews } from "./protocol";

/** What there is to run, and what the person may be led to. */
export interface Outlook {
  run: RunNews | null;
  /** The world that is open; null for none, and where another began the run. */
  world: { path: string; hasRobot: boolean } | null;
  live: boolean;
  /** Whose keys count. */
  robot: string;
  /** Whether somebody has driven in this run by keys: then it is known how. */
  driven: boolean;
  /** Whether the run is of another world than the one that is open. */
  other: boolean;
}

export interface Ways {
  open(): void;
  make(): void;
  edit(): void;
  review(recording: string): void;
}

type Way = [label: string, go: () => void];

export class Advice {
  readonly element = el("div", { class: "run-advice", role: "status", hidden: true });
  private said = "";

  constructor(private readonly ways: Ways) {}

  show(outlook: Outlook): void {
    const [text, ...ways] = this.advise(outlook);
    if (text === this.said) return;
    this.said = text;
    this.element.hidden = text === "";
    const buttons = ways.map(([label, go], k) => button({ class: k ? "" : "primary" }, go, label));
    fill(this.element, el("p", {}, text), ...buttons);
  }

  private advise(outlook: Outlook): [string, ...Way[]] {
    const { run, world, live } = outlook;
    const state = run?.state ?? "idle";
    if (live) return [""];
    if (state === "loading") return ["Loading the world …"];
    if (run && (state === "running" || state === "paused")) return [whileRunning(run, outlook)];
    if (run?.recording && state === "ended")
      return [`Recorded to ${run.recording}.`, ["Review it", () => this.ways.review(run.recording ?? "")]];
    if (!world)
      return ["No world is open: make or open one.", ["New world", this.ways.make], ["Open a world", this.ways.open]];
    if (!world.hasRobot)
      return ["No robot is in this world: put one in, with R in Edit.", ["Go to Edit", this.ways.edit]];
    return [""];
  }
}

function whileRunning(run: RunNews, { other, robot, driven }: Outlook): string {
  if (other) return `This is the run of ${run.path || run.name || "another world"}. Stop it to see the one that is open.`;
  const chosen = run.drivers?.[robot];
  if (driven || !run.controllable || !chosen || chosen.navigator !== null) return "";
  return "No navigator: drive with W A S D, or choose one in Setup.";
}
