/** Sliders for the joints of a robot's arms, and fields for where their tools are. */

import type { Values } from "../api";
import { el } from "../ui/dom";
import { sign } from "../ui/icons";
import { draw, html, unheld, type View } from "../ui/view";
import { word } from "../words/words";
import { jointRow } from "./joint_rows";
import { dragged, rounded, scale, shown } from "./joint_units";
import type { Leader } from "./leader";
import type { ArmFacts, RobotFacts, RobotTick } from "./protocol";

const TOOL = ["x", "y", "z", "roll", "pitch", "yaw"] as const;

interface Part {
  facts: ArmFacts;
  /** Where the joints and the tool were when they were last told of, and where the hand wants the joints, if it does. */
  goal: number[];
  tool: number[];
  wanted: number[] | null;
}

/** One group for each arm of the robot that is shown. */
export class ArmPanel {
  readonly element = el("div", { class: "run-noise run-arms" });
  private parts: Part[] = [];
  private robot = "";
  private enabled = false;
  /** Whether there are joints elsewhere. */
  private others = false;

  constructor(private readonly leader: Leader) {
    this.draw();
  }

  /** Whether it shows arms. */
  get known(): boolean {
    return this.parts.length > 0;
  }

  /** Take up the arms of a robot, null for none; `others`: there are joints elsewhere. */
  show(robot: RobotFacts | null, enabled: boolean, others: boolean): void {
    const name = robot?.name ?? "";
    const arms = robot?.arms ?? [];
    const namesOf = (all: ArmFacts[]): string => all.map((arm) => arm.name).join();
    if (name !== this.robot || namesOf(arms) !== namesOf(this.parts.map(({ facts }) => facts)))
      this.parts = arms.map((facts) => ({ facts, goal: [], tool: [], wanted: null }));
    [this.robot, this.enabled, this.others] = [name, enabled, others];
    this.draw();
  }

  /** Show where the arms are; what is being dragged or typed is left to the hand. */
  tick(news: RobotTick | undefined): void {
    for (const part of this.parts) {
      const { goal, tool } = news?.arms?.[part.facts.name] ?? part;
      Object.assign(part, { goal, tool });
    }
    this.draw();
  }

  private draw(): void {
    const hint = html`<p class="hint" ?hidden=${this.others}>${word("run.startARunOfA")}</p>`;
    draw(this.element, this.known ? this.parts.map((part) => this.part(part)) : hint);
  }

  private part(part: Part): View {
    const { facts } = part;
    const rows = facts.joints.map((joint, k) => {
      const event = (value: number): Values => this.jointEvent(part, k, value * scale(joint));
      return jointRow(joint, {
        label: joint.name,
        at: (part.wanted ?? part.goal)[k],
        enabled: this.enabled,
        slide: (to) => this.leader.lead(event(dragged(joint, to))),
        end: (to) => this.leader.end(event(dragged(joint, to))),
        enter: (value) => this.leader.touch(event(value)),
      });
    });
    const release = (): void => {
      part.wanted = null;
      this.leader.touch({ release: this.robot, arm: facts.name });
    };
    return html`<h2>${facts.name}</h2>${rows}
      <div class="run-tool" role="group" aria-label=${word("run.poseOfTheToolIn", { name: facts.name })}
        @change=${(event: Event) => this.moveTool(part, event)}>${TOOL.map((_, k) => this.toolField(part, k))}</div>
      <button type="button" class="quiet" title=${word("run.letTheNavigatorMoveThis")} ?disabled=${!this.enabled}
        @click=${release}>${sign("restart")}${word("run.giveBack")}</button>`;
  }

  private toolField({ facts, tool }: Part, k: number): View {
    const [unit, step, scale, digits] = k < 3 ? (["m", 0.01, 1, 4] as const) : (["°", 1, 180 / Math.PI, 2] as const);
    const [part, value] = [TOOL[k], tool[k]];
    const text = value === undefined ? "" : (value * scale).toFixed(digits);
    return html`<label><span>${part} [${unit}]</span><input type="number" step=${step} ?disabled=${!this.enabled}
      aria-label=${word("run.toolOf", { arm: facts.name, part })} .value=${unheld(text)}></label>`;
  }

  private jointEvent(part: Part, k: number, value: number): Values {
    part.wanted ??= [...part.goal];
    part.wanted[k] = value;
    const joints_deg = part.facts.joints.map((joint, j) => rounded(shown(joint, part.wanted?.[j] ?? 0)));
    return { reach: this.robot, arm: part.facts.name, joints_deg };
  }

  private moveTool(part: Part, { currentTarget }: Event): void {
    part.wanted = null;
    const pose = [...(currentTarget as HTMLElement).querySelectorAll("input")].map((field) => field.valueAsNumber);
    if (pose.some(Number.isNaN)) return;
    this.leader.touch({ reach: this.robot, arm: part.facts.name, tool: pose.slice(0, 3), rpy_deg: pose.slice(3) });
  }
}
