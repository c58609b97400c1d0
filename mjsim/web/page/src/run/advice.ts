/** What to do next, in a word over the large view of a run. */

import type { Item } from "../api";
import { el } from "../ui/dom";
import { draw, html } from "../ui/view";
import { word } from "../words/words";
import type { RunNews } from "./protocol";

/** What there is to run, and what the person may be led to. */
export interface Outlook {
  run: RunNews | null;
  /** The world that is open; null for none, and where another began the run. */
  world: { path: string; isBroken: boolean; hasMotion: boolean } | null;
  live: boolean;
  /** Whose keys count. */
  robot: string;
  /** What holds it up; "" for nothing. */
  holdUp: string;
  /** Whether somebody has driven in this run by keys: then it is known how. */
  driven: boolean;
  /** Whether the run is of another world than the one that is open. */
  other: boolean;
}

/** Whether a thing moves by itself in a run. */
export function canMove({ kind }: Item): boolean {
  return ["robot", "mechanism", "person"].includes(kind);
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

  constructor(private readonly ways: Ways) {}

  show(outlook: Outlook): void {
    const [text, ...ways] = this.advise(outlook);
    this.element.hidden = text === "";
    const buttons = ways.map(
      ([label, go], k) => html`<button type="button" class=${k ? "" : "primary"} @click=${go}>${label}</button>`,
    );
    draw(this.element, html`<p>${text}</p>${buttons}`);
  }

  private advise(outlook: Outlook): [string, ...Way[]] {
    const { run, world, live } = outlook;
    const state = run?.state ?? "idle";
    if (live) return [""];
    if (state === "loading") return [word("run.loadingTheWorld")];
    if (run && (state === "running" || state === "paused")) return [whileRunning(run, outlook)];
    if (run?.recording && state === "ended")
      return [
        word("run.recordedTo", { recording: run.recording }),
        [word("run.reviewIt"), () => this.ways.review(run.recording ?? "")],
      ];
    if (!world)
      return [
        word("run.noWorldIsOpenMake"),
        [word("run.newWorld"), this.ways.make],
        [word("run.openAWorld"), this.ways.open],
      ];
    if (world.isBroken) return [word("run.theWorldHasErrors"), [word("run.goToEdit"), this.ways.edit]];
    if (!world.hasMotion) return [word("run.noRobotIsInThis"), [word("run.goToEdit"), this.ways.edit]];
    return [""];
  }
}

function whileRunning(run: RunNews, { other, robot, driven, holdUp }: Outlook): string {
  if (other) return word("run.thisIsTheRunOf", { world: run.path || run.name || word("run.anotherWorld") });
  if (holdUp) return holdUp;
  const chosen = run.drivers?.[robot];
  const drives = run.robots.find(({ name }) => name === robot)?.can_drive;
  if (driven || !drives || !run.controllable || !chosen || chosen.navigator !== null) return "";
  return word("run.noNavigatorDriveWithW");
}
