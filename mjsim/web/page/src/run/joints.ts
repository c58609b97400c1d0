/** All about the joints of a run: sliders of arms and mechanisms, and how all joints move. */

import type { Toasts } from "../shell/toasts";
import { el } from "../ui/dom";
import { draw, html } from "../ui/view";
import { word } from "../words/words";
import { ArmPanel } from "./arms";
import { JointStates } from "./joint_states";
import type { Leader } from "./leader";
import { MechanismPanel } from "./mechanisms";
import type { RunNews, TickNews } from "./protocol";

export class JointPanel {
  readonly element: HTMLElement;
  private readonly arms: ArmPanel;
  private readonly mechanisms: MechanismPanel;
  /** Which joints cannot be led, and why. */
  private readonly fixed = el("div", {});
  private readonly states = new JointStates();

  constructor(leader: Leader) {
    this.arms = new ArmPanel(leader);
    this.mechanisms = new MechanismPanel(leader);
    this.element = el("div", {}, this.arms.element, this.mechanisms.element, this.fixed, this.states.element);
  }

  /** Whether it shows arms. */
  get hasArms(): boolean {
    return this.arms.known;
  }

  /** Take up the joints of the robot that is chosen, and of all mechanisms. */
  show(run: RunNews | null, chosen: string, enabled: boolean): void {
    this.mechanisms.show(run?.mechanisms ?? [], enabled);
    const said = Object.keys(run?.joints ?? {}).flatMap((name) => notLed(run, name) ?? []);
    draw(
      this.fixed,
      said.map((text) => html`<p class="hint">${text}</p>`),
    );
    const facts = Object.entries(run?.joints ?? {}).filter(
      ([key]) => !key.includes("/") || key.startsWith(`${chosen}/`),
    );
    this.states.show(Object.fromEntries(facts));
    this.arms.show(run?.robots.find(({ name }) => name === chosen) ?? null, enabled, facts.length > 0);
  }

  tick(news: TickNews, chosen: string): void {
    this.arms.tick(news.robots[chosen]);
    this.mechanisms.tick(news.mechanisms);
    this.states.tick(news.joints);
  }
}

/** Say why joints of what was pressed cannot be led, if so. */
export function explainJoints(names: string[], run: RunNews | null, toasts: Toasts): void {
  const [said] = names.flatMap((name) => notLed(run, name) ?? []);
  if (said) toasts.done(said);
}

/** Why joints of a mechanism cannot be led, in a sentence; null where all can, or it is none. */
function notLed(run: RunNews | null, name: string): string | null {
  if (name.includes("/")) return null;
  const led = new Set(run?.mechanisms?.find((each) => each.name === name)?.joints.map((joint) => joint.name));
  const fixed = (run?.joints?.[name] ?? []).map((joint) => joint.name).filter((joint) => !led.has(joint));
  if (fixed.length === 0) return null;
  const values = { name, joints: fixed.join(", "), others: [...led].join(", ") };
  return word(led.size ? "run.jointsNotLed" : "run.jointsNotLedAlone", values);
}
