/** How joints move now: a table for each arm, each balancing base and each mechanism. */

import { write } from "../ui/controls";
import { el } from "../ui/dom";
import { word } from "../words/words";
import { shown, unit } from "./joint_units";
import type { JointFacts, JointRow } from "./protocol";

interface Line {
  facts: JointFacts;
  cells: HTMLElement[];
}

export class JointStates {
  readonly element = el("div", { class: "run-noise run-states" });
  private tables: Record<string, Line[]> = {};
  private shape = "";

  /** Take up the joints that there are. */
  show(facts: Record<string, JointFacts[]>): void {
    const shape = JSON.stringify(facts);
    if (shape === this.shape) return;
    this.shape = shape;
    this.tables = {};
    const made = Object.entries(facts).flatMap(([key, joints]) => this.table(key, joints));
    this.element.replaceChildren(...made);
  }

  /** Show how they move; what is not told has dashes. */
  tick(rows: Record<string, Record<string, JointRow>> | undefined): void {
    if (!this.element.offsetParent) return;
    for (const [key, lines] of Object.entries(this.tables))
      for (const { facts, cells } of lines) {
        const texts = read(facts, rows?.[key]?.[facts.name] ?? []);
        for (const [k, cell] of cells.entries()) write(cell, texts[k] ?? "");
      }
  }

  private table(key: string, joints: JointFacts[]): HTMLElement[] {
    const lines = joints.map((facts): Line => ({ facts, cells: [el("td", {}), el("td", {}), el("td", {})] }));
    this.tables[key] = lines;
    const heads = ["run.joint", "run.position", "run.speedOfJoint", "run.torque"] as const;
    const rows = lines.map(({ facts: { name }, cells }) =>
      el("tr", { "data-joint": `${key}.${name}` }, el("th", { scope: "row", title: name }, name), ...cells),
    );
    const head = el("thead", {}, el("tr", {}, ...heads.map((each) => el("th", { scope: "col" }, word(each)))));
    const label = word("run.jointsOf", { name: key });
    return [el("h2", {}, key), el("table", { "aria-label": label }, head, el("tbody", {}, ...rows))];
  }
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
