/** Tools of the plan of a run beside the hand: one gives a robot a goal, one measures. */

import type { Point, Values } from "../api";
import type { Spot, Tool } from "../plan/gestures";
import type { Plan } from "../plan/plan";
import type { Door } from "../scene/door";
import { isPressed, setPressed, toggle } from "../ui/controls";
import { el } from "../ui/dom";
import { icon } from "../ui/icons";
import { readTokens } from "../ui/ink";
import { Signal } from "../ui/signal";
import { word } from "../words/words";
import { goalEvent, measured } from "./aim";

/** A press that moves less than this has no direction [px]. */
const SLIP = 8;
/** In 3-D, a drag that is shorter has no direction [m]. */
const LEAST = 0.15;
/** Length of an arrow's head [px]. */
const HEAD = 12;

/** A drag from one place of the floor to another. */
abstract class Dragged implements Tool {
  readonly cursor = "crosshair";
  protected from: Point | null = null;
  protected to: Point = [0, 0];

  constructor(protected readonly plan: Plan) {
    plan.overlay.push(
      (context) => this.from && this.draw(context, plan.view.toScreen(this.from), plan.view.toScreen(this.to)),
    );
  }

  protected abstract draw(context: CanvasRenderingContext2D, from: Point, to: Point): void;

  down({ world }: Spot): boolean {
    this.from = this.to = world;
    this.plan.drawOver();
    return true;
  }

  drag({ world }: Spot): void {
    this.to = world;
    this.plan.drawOver();
  }

  cancel(): void {
    this.from = null;
    this.plan.drawOver();
  }
}

/** The place that is pressed is the goal, the direction of the drag the heading there. */
class Goal extends Dragged {
  readonly set = new Signal<[from: Point, to: Point]>();

  up(): void {
    if (this.from) this.set.emit([this.from, this.to]);
    this.cancel();
  }

  protected draw(context: CanvasRenderingContext2D, from: Point, to: Point): void {
    context.strokeStyle = context.fillStyle = readTokens().accent;
    context.lineWidth = 2.5;
    context.beginPath();
    context.arc(...from, 6, 0, 2 * Math.PI);
    if (Math.hypot(to[0] - from[0], to[1] - from[1]) >= SLIP) arrow(context, from, to);
    context.stroke();
  }
}

/** The line stays, with its length, until another is drawn. */
class Ruler extends Dragged {
  protected draw(context: CanvasRenderingContext2D, from: Point, to: Point): void {
    const { accent, ink, paper } = readTokens();
    context.strokeStyle = accent;
    context.lineWidth = 2;
    context.beginPath();
    context.moveTo(...from);
    context.lineTo(...to);
    context.stroke();
    const text = word("run.distanceAndDirection", measured(this.from ?? this.to, this.to));
    const at: Point = [(from[0] + to[0]) / 2 + 8, (from[1] + to[1]) / 2 - 8];
    context.font = "600 13px system-ui, sans-serif";
    context.lineWidth = 4;
    context.strokeStyle = paper;
    context.strokeText(text, ...at);
    context.fillStyle = ink;
    context.fillText(text, ...at);
  }
}

function arrow(context: CanvasRenderingContext2D, from: Point, to: Point): void {
  const way = Math.atan2(to[1] - from[1], to[0] - from[0]);
  context.moveTo(...from);
  context.lineTo(...to);
  for (const side of [-0.5, 0.5]) {
    context.moveTo(...to);
    context.lineTo(to[0] - HEAD * Math.cos(way + side), to[1] - HEAD * Math.sin(way + side));
  }
}

/** Switches for both; one of them holds the plan at a time, or the hand does. */
export class PlanTools {
  readonly element = el("span", { class: "run-plan-tools" });
  /** Told before one of them takes the plan. */
  readonly taken = new Signal();
  private readonly changed = new Signal();
  /** A goal that is to be sent. */
  readonly goal = new Signal<Values>();
  private readonly buttons: { button: HTMLButtonElement; tool: Dragged }[];
  private readonly aims: HTMLButtonElement;
  private robot = "";

  constructor(private readonly plan: Plan) {
    const goal = new Goal(plan);
    goal.set.on(([from, to]) => this.send(from, to, plan.px(SLIP)));
    const make = (tool: Dragged, title: string, name: "goal" | "ruler"): HTMLButtonElement =>
      toggle({ class: "quiet square", title }, false, (on) => this.take(on ? tool : null), icon(name));
    this.aims = make(goal, word("run.goalTool"), "goal");
    const ruler = new Ruler(plan);
    this.buttons = [
      { button: this.aims, tool: goal },
      { button: make(ruler, word("run.measureTool"), "ruler"), tool: ruler },
    ];
    this.aims.hidden = true;
    this.element.append(...this.buttons.map(({ button }) => button));
  }

  /** Whether presses on the floor are goals. */
  private get isAiming(): boolean {
    return isPressed(this.aims);
  }

  /** Whose goals are set; null for nobody. */
  offer(robot: string | null): void {
    this.robot = robot ?? "";
    this.aims.hidden = robot === null;
    if (robot === null && this.isAiming) this.take(null);
  }

  /** Set goals in a view in 3-D, too. */
  aimIn(solids: Door): void {
    this.changed.on(() => solids.aim(this.isAiming));
    solids.aimed.on(([from, to]) => this.send(from, to, LEAST));
  }

  /** Send a goal that was pressed somewhere, with a heading where the drag is as long as `least` [m]. */
  private send(from: Point, to: Point, least: number): void {
    this.goal.emit(goalEvent(this.robot, from, to, least));
  }

  /** Let the plan go: another tool holds it. */
  release(): void {
    for (const { button, tool } of this.buttons) {
      setPressed(button, false);
      tool.cancel();
    }
    this.plan.host.style.cursor = "";
    this.changed.emit();
  }

  private take(wanted: Dragged | null): void {
    this.release();
    if (wanted) this.taken.emit();
    for (const { button, tool } of this.buttons) setPressed(button, tool === wanted);
    this.plan.tool = wanted;
    this.plan.host.style.cursor = wanted?.cursor ?? "";
    this.changed.emit();
  }
}
