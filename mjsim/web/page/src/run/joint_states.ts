/** How joints move now: a table for each arm, each balancing base and each mechanism. */

import { el } from "../ui/dom";
import { draw, html, type View } from "../ui/view";
import { word } from "../words/words";
import { shown, unit } from "./joint_units";
import type { JointFacts, JointRow } from "./protocol";

const HEADS = ["run.joint", "run.position", "run.speedOfJoint", "run.torque"] as const;
type Rows = Record<string, Record<string, JointRow>>;

export class JointStates {
  readonly element = el("div", { class: "run-noise run-states" });
  private facts: Record<string, JointFacts[]> = {};

  /** Take up the joints that there are. */
  show(facts: Record<string, JointFacts[]>): void {
    this.facts = facts;
    this.draw({});
  }

  /** Show how they move; what is not told has dashes. */
  tick(rows: Rows | undefined): void {
    if (this.element.offsetParent) this.draw(rows ?? {});
  }

  private draw(rows: Rows): void {
    draw(
      this.element,
      Object.entries(this.facts).map(([key, joints]) => table(key, joints, rows[key] ?? {})),
    );
  }
}

function table(key: string, joints: JointFacts[], rows: Record<string, JointRow>): View {
  const heads = HEADS.map((each) => html`<th scope="col">${word(each)}</th>`);
  const lines = joints.map((facts) => {
    const cells = read(facts, rows[facts.name] ?? []).map((text) => html`<td>${text}</td>`);
    return html`<tr data-joint="${key}.${facts.name}"><th scope="row" title=${facts.name}>${facts.name}</th>${cells}</tr>`;
  });
  return html`<h2>${key}</h2><table aria-label=${word("run.jointsOf", { name: key })}><thead><tr>${heads}</tr></thead>
    <tbody>${lines}</tbody></table>`;
}

/** Position, speed and torque, with their units. */
function read(facts: JointFacts, [position, speed, torque]: Partial<JointRow>): string[] {
  const [digits, force] = facts.slides ? [3, " N"] : [1, " N m"];
  const turned = (value: number | null | undefined): number | null => (value == null ? null : shown(facts, value));
  const space = facts.slides ? " " : "";
  return [
    written(turned(position), digits, `${space}${unit(facts)}`),
    written(turned(speed), digits, `${space}${unit(facts)}/s`),
    written(torque ?? null, 2, force),
  ];
}

function written(value: number | null, digits: number, unit: string): string {
  // What rounds to nothing has no sign.
  return value === null ? "–" : `${(Number(value.toFixed(digits)) + 0).toFixed(digits)}${unit}`;
}
