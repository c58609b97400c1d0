/** A short tour of the studio: what is where, and in which order one works; in six steps that can be left at any time. */

import { remembered } from "../ui/controls";
import { el } from "../ui/dom";
import { draw, html } from "../ui/view";
import "./tour.css";
import { word } from "../words/words";
import type { Studio, ViewName } from "./view";

interface Step {
  view: ViewName;
  /** What it tells of, as a selector of styles; where that is out of sight, the step stands in the middle. */
  at: string;
  title: string;
  text: string;
}

const STEPS: Step[] = [
  { view: "edit", at: ".tools", title: word("shell.build"), text: word("shell.pickAToolThen") },
  { view: "edit", at: ".side-column", title: word("shell.findAndChange"), text: word("shell.allThingsByKind") },
  { view: "edit", at: ".dock", title: word("shell.theTextIsThe"), text: word("shell.planAndTextChange") },
  { view: "run", at: "#view-run .run-bar", title: word("shell.run"), text: word("shell.startARunPause") },
  {
    view: "review",
    at: "#view-review .run-side",
    title: word("shell.reviewAndCompare"),
    text: word("shell.whatWasRecordedIs"),
  },
  { view: "edit", at: ".bar .helping", title: word("shell.help"), text: word("shell.hereStandAllKeys") },
];
/** Between the card and what it tells of, and the edge of the page [px]. */
const GAP = 12;

/** Whether nobody has taken the tour, or left it, in this browser. */
export function isNew(): boolean {
  return remembered("tour") === null;
}

/** Go through the steps; a page without a world opens the gallery for them. */
export async function takeTour(studio: Studio): Promise<void> {
  remembered("tour", "taken");
  const { document: world, api, folder } = studio;
  const example = folder.shipped.worlds.includes("gallery") ? "gallery" : folder.shipped.worlds[0];
  try {
    if (!world.isOpen && example) {
      const opened = await api.open(`shipped:${example}`);
      if (!world.isOpen) world.take(opened);
    }
  } catch (error) {
    return studio.toasts.error(error);
  }
  new Tour(studio);
}

class Tour {
  private readonly spot = el("div", { class: "tour-spot" });
  private readonly dialog = el("dialog", { class: "tour", "aria-labelledby": "tour-title" });
  private now = 0;

  constructor(private readonly studio: Studio) {
    this.dialog.addEventListener("keydown", (event) => this.key(event));
    const place = (): void => this.place();
    window.addEventListener("resize", place);
    this.dialog.addEventListener("close", () => {
      window.removeEventListener("resize", place);
      this.dialog.remove();
    });
    document.body.append(this.dialog);
    this.dialog.showModal();
    this.go(0);
  }

  private go(to: number): void {
    const step = STEPS[to];
    if (!step) return this.dialog.close();
    this.now = to;
    this.studio.show(step.view);
    this.draw(step);
    this.dialog.querySelector<HTMLElement>(".primary")?.focus();
    this.place();
  }

  /** Heading and text are read anew at each step. */
  private draw({ title, text }: Step): void {
    const { now } = this;
    const count = STEPS.length;
    const view = html`${this.spot}<div aria-live="polite"><h2 id="tour-title">${title}</h2><p>${text}</p></div>
        <div class="choices"><span class="hint">${word("shell.of", { number: now + 1, count })}</span>
          <button type="button" class="quiet" @click=${() => this.dialog.close()}>${word("shell.leaveTheTour")}</button>
          <button type="button" ?disabled=${now === 0} @click=${() => this.go(now - 1)}>${word("shell.back")}</button>
          <button type="button" class="primary" @click=${() => this.go(now + 1)}
            >${word(now + 1 === count ? "shell.done" : "shell.next")}</button></div>`;
    draw(this.dialog, view);
  }

  private key(event: KeyboardEvent): void {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (step && STEPS[this.now + step]) this.go(this.now + step);
  }

  /** Frame what the step tells of, and stand beside it where there is room: right, left, below or above; else amid. */
  private place(): void {
    const box = document.querySelector(STEPS[this.now]?.at ?? "")?.getBoundingClientRect();
    const shown = box !== undefined && box.width > 0;
    this.spot.hidden = !shown;
    const { offsetWidth: width, offsetHeight: height } = this.dialog;
    const [mostX, mostY] = [window.innerWidth - width - GAP, window.innerHeight - height - GAP];
    let [x, y] = [mostX / 2, mostY / 2];
    if (shown) {
      for (const side of ["left", "top", "width", "height"] as const) this.spot.style[side] = `${box[side]}px`;
      const places: [number, number][] = [
        [box.right + GAP, box.top],
        [box.left - width - GAP, box.top],
        [within(box.left, mostX), box.bottom + GAP],
        [within(box.left, mostX), box.top - height - GAP],
      ];
      [x, y] = places.find(
        ([left, top]) => left >= GAP && left <= mostX && top >= GAP && top <= window.innerHeight - GAP,
      ) ?? [x, y];
    }
    this.dialog.style.left = `${within(x, mostX)}px`;
    this.dialog.style.top = `${within(y, mostY)}px`;
  }
}

/** A place that is on the page [px]. */
function within(wanted: number, most: number): number {
  return Math.max(GAP, Math.min(wanted, most));
}
