/** All about the joints of a run: sliders of arms and mechanisms, and how all joints move. */

import type { Values } from "../api";
import { el } from "../dom";
import { ArmPanel } from "./arms";
import { JointStates } from "./joint_states";
import { MechanismPanel } from "./mechanisms";
import type { RunNews, TickNews } from "./protocol";

export class JointPanel {
  readonly element: HTMLElement;
  private readonly arms: ArmPanel;
  private readonly mechanisms: MechanismPanel;
  private readonly states = new JointStates();

  /** `send` takes touches of the run, as events of a world file. */
  constructor(send: (event: Values) => void) {
    this.arms = new ArmPanel(send);
    this.mechanisms = new MechanismPanel(send);
    this.element = el("div", {}, this.arms.element, this.mechanisms.element, this.states.element);
  }

  /** Whether it shows arms. */
  get hasArms(): boolean {
    return this.arms.known;
  }

  /** Take up the joints of the robot that is chosen, and of all mechanisms. */
  show(run: RunNews | null, chosen: string, enabled: boolean): void {
    this.arms.show(run?.robots.find(({ name }) => name === chosen) ?? null, enabled);
    this.mechanisms.show(run?.mechanisms ?? [], enabled);
    const facts = Object.entries(run?.joints ?? {}).filter(([key]) => !key.includes("/") || key.startsWith(`${chosen}/`));
    this.states.show(Object.fromEntries(facts));
    this.arms.hint.hidden = facts.length > 0;
  }

  tick(news: TickNews, chosen: string): void {
    this.arms.tick(news.robots[chosen]);
    this.mechanisms.tick(news.mechanisms);
    this.states.tick(news.joints);
  }
}
