/** Sliders for the joints of mechanisms that can be led. */

import type { Values } from "../api";
import { button } from "../ui/controls";
import { el } from "../ui/dom";
import { icon } from "../ui/icons";
import { word } from "../words/words";
import { jointRow, line, put, type Row, whenEntered } from "./arms";
import { dragged, rounded, shown, unit } from "./joint_units";
import type { Leader } from "./leader";
import type { MechanismFacts, MechanismTick } from "./protocol";

interface Part {
  facts: MechanismFacts;
  rows: Row[];
  /** Of its joints, when they were last told of [rad, m]. */
  positions: number[];
}

/** One group for each mechanism. A slider leads its joint while it is dragged. */
export class MechanismPanel {
  readonly element = el("div", { class: "run-noise run-mechanisms" });
  private parts: Part[] = [];
  private releases: HTMLButtonElement[] = [];
  private shape = "";

  constructor(private readonly leader: Leader) {}

  show(mechanisms: MechanismFacts[], enabled: boolean): void {
    const shape = JSON.stringify(mechanisms);
    if (shape !== this.shape) this.build(mechanisms);
    this.shape = shape;
    for (const { slider, field } of this.parts.flatMap((part) => part.rows))
      slider.disabled = field.disabled = !enabled;
    for (const each of this.releases) each.disabled = !enabled;
  }

  /** Show where joints are; what is being dragged or typed is left to the hand. */
  tick(news: Record<string, MechanismTick> | undefined): void {
    for (const part of this.parts) {
      part.positions = news?.[part.facts.name]?.positions ?? part.positions;
      part.rows.forEach((row, k) => {
        const value = part.positions[k] ?? 0;
        if (document.activeElement !== row.slider) row.slider.value = String(value - turns(row, value));
        put(row.field, shown(row.facts, value));
      });
    }
  }

  private build(mechanisms: MechanismFacts[]): void {
    this.releases = [];
    this.parts = mechanisms.map((facts) => ({ facts, rows: facts.joints.map(jointRow), positions: [] }));
    this.element.replaceChildren(...this.parts.flatMap((part) => this.group(part)));
  }

  private group(part: Part): HTMLElement[] {
    const { facts, rows } = part;
    rows.forEach((row, k) => {
      const event = (value: number): Values => ({ lead: facts.name, joint: row.facts.name, to_deg: rounded(value) });
      // A drag of a slider stays in the turn in which it began.
      let whole: number | null = null;
      const slid = (): Values => {
        whole ??= turns(row, part.positions[k] ?? 0);
        return event(dragged(row.facts, Number(row.slider.value) + whole));
      };
      row.slider.addEventListener("input", () => {
        put(row.field, shown(row.facts, Number(row.slider.value)));
        this.leader.lead(slid());
      });
      row.slider.addEventListener("change", () => {
        this.leader.end(slid());
        whole = null;
      });
      whenEntered(row.field, (value) => this.leader.touch(event(value)));
    });
    const lines = rows.map((row) => {
      const made = line(row.facts.name, row.slider, row.field, unit(row.facts), this.release(facts.name, row));
      made.title = word(row.facts.held ? "run.heldThereByAHand" : "run.ledThereAtRadS");
      return made;
    });
    return [el("h2", {}, facts.name), ...lines];
  }

  /** A button that gives a joint back. */
  private release(release: string, { facts }: Row): HTMLButtonElement {
    const title = word(facts.held ? "run.letGoOf" : "run.letItFollowItsSignal", { joint: facts.name });
    const made = button(
      { class: "quiet square", title },
      () => this.leader.touch({ release, joint: facts.name }),
      icon("restart"),
    );
    this.releases.push(made);
    return made;
  }
}

/** Whole turns of a joint without limits, and rounds of a closed curve, which its slider leaves out [rad, m]. */
function turns({ facts }: Row, value: number): number {
  if (facts.period) return facts.period * Math.floor(value / facts.period);
  const isFree = !facts.slides && facts.lower === null && facts.upper === null;
  return isFree ? 2 * Math.PI * Math.round(value / (2 * Math.PI)) : 0;
}
