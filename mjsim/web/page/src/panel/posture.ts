/** How a mechanism or a person starts: drawn from aside, with a slider for each value of a joint. */

import type { Item, JointValue, Look, Pose } from "../api";
import type { Editor } from "../edit/editor";
import type { Poser } from "../edit/poser";
import { keyOf } from "../plan/plan";
import { el } from "../ui/dom";
import { choice, draw, html, keyed, nothing, repeat, unheld, type View, withNumber } from "../ui/view";
import { word } from "../words/words";
import { SideDrawing } from "./side";

const LOOKS = [["side", word("panel.fromTheSide")] as const, ["front", word("panel.fromAhead")] as const];
const HELD = word("panel.theActuatorsOrTheSeat");
const AXES = ["x", "y", "z"] as const;

export class PosturePane {
  readonly element = el("section", { class: "posture", "aria-label": word("panel.pose"), hidden: true });
  private readonly poser: Poser;
  private readonly drawing: SideDrawing;

  constructor(private readonly editor: Editor) {
    this.poser = editor.poser;
    this.drawing = new SideDrawing(this.poser, () => this.poser.subject);
    this.poser.changed.on(() => this.draw());
  }

  private draw(): void {
    const { pose, note, subject, joint, look } = this.poser;
    this.element.hidden = !subject || (!pose && !note);
    if (subject && pose) this.drawing.show(pose, subject);
    else this.drawing.clear();
    const choose = (wanted: Look): unknown => (this.poser.look = wanted);
    const whole = (): unknown => subject && this.editor.select([subject]);
    const head = html`<div class="preview-head"><span>${word("panel.pose")}</span>
      <button class="quiet" title=${word("panel.selectTheWholeMechanism")} ?hidden=${joint === null}
        @click=${whole}>${word("panel.whole")}</button>
      ${choice(word("panel.viewOfThePose"), LOOKS, look, choose)}</div>`;
    const rows = subject && pose ? keyed(keyOf(subject.path), this.rows(pose, subject)) : null;
    const view = html`${head}${this.drawing.element}<p class="hint posture-note" role="status">${note}</p>
        <div class="posture-rows">${rows}</div>`;
    draw(this.element, view);
  }

  private rows(pose: Pose, { fixed, kind }: Item): View {
    const hands = Object.entries(pose.hands).map(([side, at]) => this.handRow(side, at, fixed !== null));
    const row = (value: JointValue): View => this.row(value, fixed !== null);
    const group = ({ name }: JointValue): string => (kind === "person" ? groupOf(name) : "");
    const made = [...new Set(pose.values.map(group))].map((name) => {
      const own = pose.values.filter((value) => group(value) === name);
      const rows = repeat(own, (value) => value.name, row);
      return name ? html`<details class="posture-group"><summary>${name}</summary>${rows}</details>` : rows;
    });
    return html`${hands}${made}`;
  }

  private row({ name, low, high, unit, free, value }: JointValue, fixed: boolean): View {
    const disabled = fixed || !free;
    const title = free ? nothing : HELD;
    const give = (to: number): void => this.poser.follow({ values: { [name]: to } });
    const keep = (to: number): void => {
      give(to);
      void this.poser.keep();
    };
    return html`<div class="posture-row"><span>${name.replaceAll("_", " ")}</span>
      <input type="range" min=${low} max=${high} step="any" ?disabled=${disabled} title=${title} aria-label=${name}
        .value=${unheld(String(value))} @input=${withNumber(give)} @change=${() => this.poser.keep()}>
      <input type="number" step="any" ?disabled=${disabled} title=${title} aria-label="${name}, ${unit}"
        .value=${unheld(rounded(value, unit === "m" ? 4 : 2))} @change=${withNumber(keep)} @blur=${this.refresh}>${unit}</div>`;
  }

  private handRow(side: string, at: readonly number[], fixed: boolean): View {
    const hand = handName(side);
    const fields = AXES.map(
      (axis, k) => html`<input type="number" step="0.01" ?disabled=${fixed} .value=${unheld(rounded(at[k] ?? 0, 3))}
        aria-label=${word("panel.handAxis", { hand, axis })} @blur=${this.refresh}>`,
    );
    return html`<div class="posture-row posture-hand" @change=${(event: Event) => this.lead(side, event)}>
      <span>${hand}</span>${fields}m</div>`;
  }

  /** A field that is left without a number shows the value again. */
  private readonly refresh = (event: Event): void => {
    if (Number.isNaN((event.target as HTMLInputElement).valueAsNumber)) this.draw();
  };

  private lead(side: string, { currentTarget }: Event): void {
    const fields = (currentTarget as HTMLElement).querySelectorAll("input");
    const [x = 0, y = 0, z = 0] = [...fields].map(({ valueAsNumber }) => valueAsNumber);
    if ([x, y, z].some(Number.isNaN)) return;
    this.poser.follow({ hands: { [side]: [x, y, z] } });
    void this.poser.keep();
  }
}

/** Which part of a person a joint belongs to. */
function groupOf(name: string): string {
  if (name.startsWith("left_")) return word("panel.leftSide");
  return name.startsWith("right_") ? word("panel.rightSide") : word("panel.trunkAndHead");
}

function rounded(value: number, digits: number): string {
  return String(Number(value.toFixed(digits)));
}

/** Hands are sides of the body; those of other robots go by their own names. */
function handName(side: string): string {
  return side === "left" ? word("panel.leftHand") : side === "right" ? word("panel.rightHand") : side;
}
