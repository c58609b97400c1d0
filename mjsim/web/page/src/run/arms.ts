/** Sliders for the joints of a robot's arms, and fields for where their tools are. The rows serve mechanisms as well. */

import type { Values } from "../api";
import { button } from "../ui/controls";
import { el, fill } from "../ui/dom";
import { icon } from "../ui/icons";
import { word } from "../words/words";
import { dragged, rounded, scale, shown, unit } from "./joint_units";
import type { Leader } from "./leader";
import type { ArmFacts, JointFacts, RobotFacts, RobotTick } from "./protocol";

const HINT = word("run.startARunOfA");
const TOOL = ["x", "y", "z", "roll", "pitch", "yaw"] as const;
/** How far sliders of joints without limits go, of those that turn and of those that slide [rad, m]. */
const FREE = [Math.PI, 1] as const;

export interface Row {
  slider: HTMLInputElement;
  field: HTMLInputElement;
  facts: JointFacts;
}

interface Part {
  facts: ArmFacts;
  rows: Row[];
  tool: HTMLInputElement[];
  release: HTMLButtonElement;
  /** Where the joints were when they were last told of, and where the hand wants them; null while it wants nothing. */
  goal: number[];
  wanted: number[] | null;
}

/** One group for each arm of the robot that is shown. */
export class ArmPanel {
  readonly element = el("div", { class: "run-noise run-arms" });
  /** Stands here where there is nothing to move. */
  readonly hint = el("p", { class: "hint" }, HINT);
  private parts: Part[] = [];
  private robot = "";
  private enabled = false;

  constructor(private readonly leader: Leader) {
    this.show(null, false);
  }

  /** Whether it shows arms. */
  get known(): boolean {
    return this.parts.length > 0;
  }

  /** Take up the arms of a robot, null for none. */
  show(robot: RobotFacts | null, enabled: boolean): void {
    const name = robot?.name ?? "";
    const same = name === this.robot && robot?.arms.map((arm) => arm.name).join() === this.names();
    this.robot = name;
    this.enabled = enabled;
    if (!same || this.parts.length === 0) this.build(robot?.arms ?? []);
    for (const part of this.parts) this.enable(part);
  }

  /** Show where the arms are; what is being dragged or typed is left to the hand. */
  tick(news: RobotTick | undefined): void {
    for (const part of this.parts) {
      const now = news?.arms?.[part.facts.name];
      if (!now) continue;
      part.goal = now.goal;
      part.rows.forEach((row, k) => {
        const value = (part.wanted ?? now.goal)[k] ?? 0;
        if (document.activeElement !== row.slider) row.slider.value = String(value);
        put(row.field, shown(row.facts, value));
      });
      for (const [k, field] of part.tool.entries()) {
        put(field, (now.tool[k] ?? 0) * (k < 3 ? 1 : 180 / Math.PI), k < 3 ? 4 : 2);
      }
    }
  }

  private names(): string {
    return this.parts.map((part) => part.facts.name).join();
  }

  private build(arms: ArmFacts[]): void {
    this.parts = [];
    if (arms.length === 0) return fill(this.element, this.hint);
    this.element.replaceChildren();
    for (const facts of arms) this.element.append(...this.part(facts));
  }

  private part(facts: ArmFacts): HTMLElement[] {
    const rows = facts.joints.map(jointRow);
    const tool = TOOL.map((name, k) =>
      this.field(word("run.toolOf", { arm: facts.name, part: name }), () => this.moveTool(part), k < 3 ? 0.01 : 1),
    );
    const release = button(
      { class: "quiet", title: word("run.letTheNavigatorMoveThis") },
      () => {
        part.wanted = null;
        this.leader.touch({ release: this.robot, arm: facts.name });
      },
      icon("restart"),
      word("run.giveBack"),
    );
    const part: Part = { facts, rows, tool, release, goal: [], wanted: null };
    this.parts.push(part);
    rows.forEach((row, k) => {
      const slid = (): Values =>
        this.jointEvent(part, k, dragged(row.facts, Number(row.slider.value)) * scale(row.facts));
      row.slider.addEventListener("input", () => this.leader.lead(slid()));
      row.slider.addEventListener("change", () => this.leader.end(slid()));
      whenEntered(row.field, (value) => this.leader.touch(this.jointEvent(part, k, value * scale(row.facts))));
    });
    return [
      el("h2", {}, facts.name),
      ...rows.map((row, k) => line(facts.joints[k]?.name ?? "", row.slider, row.field, unit(row.facts))),
      el(
        "div",
        { class: "run-tool", role: "group", "aria-label": word("run.poseOfTheToolIn", { name: facts.name }) },
        ...TOOL.map((name, k) => el("label", {}, el("span", {}, `${name} [${k < 3 ? "m" : "°"}]`), tool[k])),
      ),
      release,
    ];
  }

  private field(label: string, changed: () => void, step: number): HTMLInputElement {
    const field = el("input", { type: "number", step, "aria-label": label });
    field.addEventListener("change", changed);
    return field;
  }

  private enable(part: Part): void {
    const inputs = [...part.rows.flatMap((row) => [row.slider, row.field]), ...part.tool];
    for (const input of inputs) input.disabled = !this.enabled;
    part.release.disabled = !this.enabled;
  }

  private jointEvent(part: Part, k: number, value: number): Values {
    part.wanted ??= [...part.goal];
    part.wanted[k] = value;
    const joints_deg = part.rows.map((row, j) => rounded(shown(row.facts, part.wanted?.[j] ?? 0)));
    return { reach: this.robot, arm: part.facts.name, joints_deg };
  }

  private moveTool(part: Part): void {
    const { facts, tool } = part;
    part.wanted = null;
    const pose = tool.map((field) => field.valueAsNumber);
    if (pose.some(Number.isNaN)) return;
    this.leader.touch({ reach: this.robot, arm: facts.name, tool: pose.slice(0, 3), rpy_deg: pose.slice(3) });
  }
}

/** A slider and a field of a joint. */
export function jointRow(facts: JointFacts): Row {
  const free = FREE[facts.slides ? 1 : 0];
  const slider = el("input", {
    type: "range",
    min: facts.lower ?? (facts.period ? 0 : -free),
    max: facts.upper ?? facts.period ?? free,
    step: "any",
    "aria-label": facts.name,
  });
  const field = el("input", { type: "number", step: "any", "aria-label": `${facts.name}, ${unit(facts)}` });
  return { slider, field, facts };
}

export function line(
  label: string,
  slider: HTMLElement,
  field: HTMLElement,
  unit: string,
  more: HTMLElement | null = null,
): HTMLElement {
  return el(
    "div",
    { class: "run-noise-row" },
    el("span", { class: "run-noise-label" }, label),
    slider,
    el("span", { class: "run-noise-value" }, field, el("span", { class: "run-unit" }, unit), more),
  );
}

/** Take up numbers that are entered; an empty field, or no number, means nothing: the next tick fills it again. */
export function whenEntered(field: HTMLInputElement, take: (value: number) => void): void {
  field.addEventListener("change", () => Number.isNaN(field.valueAsNumber) || take(field.valueAsNumber));
}

/** Write a number into a field in which nobody types. */
export function put(field: HTMLInputElement, value: number, digits = 2): void {
  if (document.activeElement !== field) field.value = value.toFixed(digits);
}
