/** How a mechanism or a person starts: drawn from aside, with a slider for each value of a joint. */

import type { Item, JointValue, Look, Pose } from "../api";
import type { Editor } from "../edit/editor";
import type { Poser } from "../edit/poser";
import { type Child, el, fill } from "../ui/dom";
import { word } from "../words/words";
import { SideDrawing } from "./side";

const LOOKS: Record<Look, string> = { side: word("panel.fromTheSide"), front: word("panel.fromAhead") };
const HELD = word("panel.theActuatorsOrTheSeat");
const AXES = ["x", "y", "z"] as const;

interface Row {
  name: string;
  slider: HTMLInputElement;
  field: HTMLInputElement;
}

export class PosturePane {
  readonly element = el("section", { class: "posture", "aria-label": word("panel.pose"), hidden: true });
  private readonly poser: Poser;
  private readonly look = el(
    "select",
    { "aria-label": word("panel.viewOfThePose"), onchange: () => (this.poser.look = this.look.value as Look) },
    ...Object.entries(LOOKS).map(([value, text]) => el("option", { value }, text)),
  );
  private readonly whole = el(
    "button",
    { class: "quiet", title: word("panel.selectTheWholeMechanism"), onclick: () => this.selectWhole() },
    word("panel.whole"),
  );
  private readonly note = el("p", { class: "hint posture-note", role: "status" });
  private readonly rows = el("div", { class: "posture-rows" });
  private readonly drawing: SideDrawing;
  private sliders: Row[] = [];
  private hands: { side: string; axis: number; field: HTMLInputElement }[] = [];
  private built = "";

  constructor(private readonly editor: Editor) {
    this.poser = editor.poser;
    this.drawing = new SideDrawing(this.poser, () => this.subject);
    const head = el("div", { class: "preview-head" }, el("span", {}, word("panel.pose")), this.whole, this.look);
    this.element.append(head, this.drawing.element, this.note, this.rows);
    this.poser.changed.on(() => this.draw());
  }

  private get subject(): Item | null {
    return this.poser.subject;
  }

  private draw(): void {
    const { pose, note } = this.poser;
    const { subject } = this;
    this.element.hidden = !subject || (!pose && !note);
    this.whole.hidden = this.poser.joint === null;
    this.note.textContent = note;
    if (!subject || !pose) return this.drawing.clear();
    this.build(pose, subject);
    this.drawing.show(pose, subject);
    for (const row of this.sliders)
      this.put(
        row,
        pose.values.find(({ name }) => name === row.name),
      );
    for (const { side, axis, field } of this.hands) put(field, pose.hands[side]?.[axis] ?? 0, 3);
  }

  private put(row: Row, value: JointValue | undefined): void {
    if (!value) return;
    // The range of a joint may have been edited.
    Object.assign(row.slider, { min: String(value.low), max: String(value.high) });
    if (document.activeElement !== row.slider) row.slider.value = String(value.value);
    put(row.field, value.value, value.unit === "m" ? 4 : 2);
  }

  /** Make the rows, when they are those of another thing. */
  private build(pose: Pose, subject: Item): void {
    const key = JSON.stringify([subject.path, subject.fixed, pose.values.map(({ name, free }) => [name, free])]);
    if (key === this.built) return;
    this.built = key;
    [this.sliders, this.hands] = [[], []];
    const fixed = subject.fixed !== null;
    const groups = new Map<string, HTMLElement[]>();
    for (const value of pose.values) {
      const group = subject.kind === "person" ? groupOf(value.name) : "";
      groups.set(group, [...(groups.get(group) ?? []), this.row(value, fixed)]);
    }
    const made = [...groups].flatMap(([name, rows]): Child[] =>
      name ? [el("details", { class: "posture-group" }, el("summary", {}, name), ...rows)] : rows,
    );
    fill(this.rows, ...Object.keys(pose.hands).map((side) => this.handRow(side, fixed)), ...made);
  }

  private row({ name, low, high, unit, free }: JointValue, fixed: boolean): HTMLElement {
    const disabled = fixed || !free;
    const title = free ? null : HELD;
    const slider = el("input", {
      type: "range",
      min: low,
      max: high,
      step: "any",
      disabled,
      title,
      "aria-label": name,
    });
    const field = el("input", { type: "number", step: "any", disabled, title, "aria-label": `${name}, ${unit}` });
    const give = (input: HTMLInputElement): void => {
      if (input.value !== "") this.poser.follow({ values: { [name]: Number(input.value) } });
    };
    slider.addEventListener("input", () => give(slider));
    slider.addEventListener("change", () => void this.poser.keep());
    field.addEventListener("change", () => {
      if (Number.isNaN(field.valueAsNumber)) return;
      give(field);
      void this.poser.keep();
    });
    this.refillOnLeaving(field);
    this.sliders.push({ name, slider, field });
    return el("div", { class: "posture-row" }, el("span", {}, name.replaceAll("_", " ")), slider, field, unit);
  }

  private handRow(side: string, fixed: boolean): HTMLElement {
    const fields = AXES.map((axis, k) => {
      const label = word("panel.handAxis", { hand: handName(side), axis });
      const field = el("input", { type: "number", step: 0.01, disabled: fixed, "aria-label": label });
      field.addEventListener("change", () => this.lead(side));
      this.refillOnLeaving(field);
      this.hands.push({ side, axis: k, field });
      return field;
    });
    return el("div", { class: "posture-row posture-hand" }, el("span", {}, handName(side)), ...fields, "m");
  }

  /** A field that is left empty, or without a number, shows the value again. */
  private refillOnLeaving(field: HTMLInputElement): void {
    field.addEventListener("blur", () => Number.isNaN(field.valueAsNumber) && this.draw());
  }

  private lead(side: string): void {
    const [x = 0, y = 0, z = 0] = this.hands
      .filter((hand) => hand.side === side)
      .map(({ field }) => field.valueAsNumber);
    if ([x, y, z].some(Number.isNaN)) return;
    this.poser.follow({ hands: { [side]: [x, y, z] } });
    void this.poser.keep();
  }

  private selectWhole(): void {
    if (this.subject) this.editor.select([this.subject]);
  }
}

/** Which part of a person a joint belongs to. */
function groupOf(name: string): string {
  if (name.startsWith("left_")) return word("panel.leftSide");
  return name.startsWith("right_") ? word("panel.rightSide") : word("panel.trunkAndHead");
}

/** Write a number into a field in which nobody types. */
function put(field: HTMLInputElement, value: number, digits: number): void {
  if (document.activeElement !== field) field.value = String(Number(value.toFixed(digits)));
}

/** Hands are sides of the body; those of other robots go by their own names. */
function handName(side: string): string {
  return side === "left" ? word("panel.leftHand") : side === "right" ? word("panel.rightHand") : side;
}
