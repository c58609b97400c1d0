/** Sliders for the joints of mechanisms that can be led. */

import type { Values } from "../api";
import { el } from "../ui/dom";
import { iconButton } from "../ui/icons";
import { draw, html, type View } from "../ui/view";
import { word } from "../words/words";
import { jointRow } from "./joint_rows";
import { dragged, rounded } from "./joint_units";
import type { Leader } from "./leader";
import type { JointFacts, MechanismFacts, MechanismTick } from "./protocol";

interface Part {
  facts: MechanismFacts;
  /** Of its joints, when they were last told of or dragged [rad, m]. */
  positions: number[];
  /** Of joints that are dragged, the turns in which that began [rad, m]. */
  whole: Map<number, number>;
}

/** One group for each mechanism. A slider leads its joint while it is dragged. */
export class MechanismPanel {
  readonly element = el("div", { class: "run-noise run-mechanisms" });
  private parts: Part[] = [];
  private enabled = false;

  constructor(private readonly leader: Leader) {}

  show(mechanisms: MechanismFacts[], enabled: boolean): void {
    const isSame = JSON.stringify(mechanisms) === JSON.stringify(this.parts.map(({ facts }) => facts));
    if (!isSame) this.parts = mechanisms.map((facts) => ({ facts, positions: [], whole: new Map() }));
    this.enabled = enabled;
    this.draw();
  }

  /** Show where joints are; what is being dragged or typed is left to the hand. */
  tick(news: Record<string, MechanismTick> | undefined): void {
    for (const part of this.parts) part.positions = news?.[part.facts.name]?.positions ?? part.positions;
    this.draw();
  }

  private draw(): void {
    draw(
      this.element,
      this.parts.map((part) => html`<h2>${part.facts.name}</h2>${part.facts.joints.map((_, k) => this.row(part, k))}`),
    );
  }

  private row({ facts, positions, whole }: Part, k: number): View {
    const joint = facts.joints[k] as JointFacts;
    const at = positions[k];
    const event = (value: number): Values => ({ lead: facts.name, joint: joint.name, to_deg: rounded(value) });
    const slid = (to: number): Values => {
      const there = to + (whole.get(k) ?? turns(joint, at ?? 0));
      whole.set(k, there - to);
      positions[k] = there;
      return event(dragged(joint, there));
    };
    return jointRow(joint, {
      label: joint.name,
      title: word(joint.held ? "run.heldThereByAHand" : "run.ledThereAtRadS"),
      at,
      turns: turns(joint, at ?? 0),
      enabled: this.enabled,
      slide: (to) => {
        this.leader.lead(slid(to));
        this.draw();
      },
      end: (to) => {
        this.leader.end(slid(to));
        whole.delete(k);
      },
      enter: (value) => this.leader.touch(event(value)),
      more: this.release(facts.name, joint),
    });
  }

  /** A button that gives a joint back. */
  private release(release: string, { name, held }: JointFacts): View {
    const title = word(held ? "run.letGoOf" : "run.letItFollowItsSignal", { joint: name });
    return iconButton("restart", title, () => this.leader.touch({ release, joint: name }), !this.enabled);
  }
}

/** Whole turns of a joint without limits, and rounds of a closed curve, which its slider leaves out [rad, m]. */
function turns(facts: JointFacts, value: number): number {
  if (facts.period) return facts.period * Math.floor(value / facts.period);
  const isFree = !facts.slides && facts.lower === null && facts.upper === null;
  return isFree ? 2 * Math.PI * Math.round(value / (2 * Math.PI)) : 0;
}
