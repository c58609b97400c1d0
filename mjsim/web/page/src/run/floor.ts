/** The plan of a run: what stands still, drawn by the plan; what moves, drawn over it. */

import type { Bounds, Item, Point } from "../api";
import { keyOf, Plan } from "../plan/plan";
import type { Thoughts } from "../scene/thoughts";
import { button, isPressed, setPressed, toggle } from "../ui/controls";
import { el } from "../ui/dom";
import { icon } from "../ui/icons";
import { makeTile, type Tile } from "../ui/tile";
import { word } from "../words/words";
import { Evidence } from "./evidence";
import { Grids } from "./grids";
import type { Joints } from "./joint_grips";
import { Layers } from "./layers";
import { Leader, NOBODY } from "./leader";
import { Overlay } from "./overlay";
import { Past } from "./past";
import { PlanTools } from "./plan_tools";
import type { JointFacts, JointGrip, JointRow, PlanarPose, RobotFacts, RobotTick } from "./protocol";
import type { RunRecord } from "./record";
import { type Standing, Touch } from "./touch";
import type { Hands } from "./touch_tools";

/** While following, so much of the world is seen at least [px/m]. */
const CLOSE = 90;

export interface Moment {
  /** [s] */
  time: number;
  robots: Record<string, RobotTick>;
  things: Record<string, PlanarPose>;
  hands?: Hands;
  people?: Record<string, Point[][]>;
  joints?: Record<string, Record<string, JointRow>>;
  bodies?: Record<string, Point[][]>;
  grips?: JointGrip[];
  removed?: string[];
}

export class Floor {
  readonly tile: Tile;
  /** Things may be laid over the plan here. */
  readonly host = el("div", { class: "run-floor", tabindex: 0, role: "group", "aria-label": word("run.planKeys") });
  private readonly plan: Plan;
  private readonly follow: HTMLButtonElement;
  /** What is drawn. */
  readonly layers = new Layers();
  private readonly past = new Past();
  private readonly grids = new Grids(() => this.plan.drawOver());
  /** What is done to the run by hand. */
  readonly touch: Touch;
  /** Give a robot a goal, and measure. */
  readonly tools: PlanTools;
  private readonly legend = legend();
  private robots: RobotFacts[] = [];
  private removed: ReadonlySet<string> = new Set();
  /** People whose hands were led, and mechanisms that stand otherwise than at the start. */
  private posed: ReadonlySet<string> = new Set();
  private facts: Record<string, JointFacts[]> = {};
  private moment: Moment | null = null;
  private chosen = "";
  private names = new Set<string>();

  constructor(
    private readonly record: RunRecord,
    leader: Leader = new Leader(NOBODY),
  ) {
    this.plan = new Plan(this.host);
    const floorplan = {
      plan: this.plan,
      robots: () => this.standing(),
      hands: () => this.moment?.hands ?? {},
      joints: () => this.joints(),
      removed: () => this.removed,
    };
    this.touch = new Touch(floorplan, leader);
    this.tools = new PlanTools(this.plan);
    this.tools.taken.on(() => isPressed(this.touch.button) && this.touch.hold(false));
    this.touch.taken.on(() => this.tools.release());
    this.tools.goal.on((event) => leader.touch(event));
    this.layers.changed.on(() => this.plan.drawOver());
    this.follow = toggle(
      { class: "quiet square", title: word("run.followTheRobotF") },
      false,
      (on) => this.setFollow(on),
      icon("follow"),
    );
    const fit = button({ class: "quiet square", title: word("run.showTheWholePlan") }, () => this.fit(), icon("fit"));
    this.tile = makeTile(
      "plan",
      word("run.plan"),
      this.host,
      this.legend,
      el("span", { class: "run-spring" }),
      this.layers.element,
      this.touch.button,
      this.tools.element,
      this.follow,
      fit,
    );
    this.plan.hiddenKinds.add("robot");
    // A joint's body is drawn with its mechanism.
    this.plan.hiddenKinds.add("joint");
    this.plan.overlay.unshift((context) => this.draw(context));
  }

  /** Where the menu of what is drawn stands: beside the large view, for the view in 3-D draws the same. */
  lendLayers(to: HTMLElement | null): void {
    if (to) to.append(this.layers.element);
    else this.touch.button.before(this.layers.element);
  }

  scene(items: Item[], bounds: Bounds): void {
    this.plan.stands.clear();
    this.layers.forget();
    const same = bounds.join() === this.plan.bounds.join() && this.names.size > 0;
    this.names = new Set(items.flatMap((item) => item.name ?? []));
    this.plan.setItems(items, bounds);
    if (!same) this.fit();
  }

  run(robots: RobotFacts[], chosen: string, joints: Record<string, JointFacts[]> = {}): void {
    this.robots = robots;
    this.facts = joints;
    this.chosen = chosen;
    this.legend.hidden = robots.length === 0;
    this.plan.drawOver();
  }

  /** Let the plan draw the robots where the world puts them, as before a run. */
  showRobots(on: boolean): void {
    if (on) this.plan.hiddenKinds.delete("robot");
    else this.plan.hiddenKinds.add("robot");
    this.plan.refresh();
  }

  show(moment: Moment): void {
    this.moment = moment;
    this.past.add(moment.time, moment.robots);
    for (const tick of Object.values(moment.robots)) this.layers.offer((tick.show ?? []).map((item) => item.name));
    const changed = [
      this.takeAway(moment.removed ?? []),
      this.move(moment.things),
      this.pose({ ...moment.people, ...moment.bodies }),
    ];
    if (changed.includes(true)) this.plan.refresh();
    const pose = moment.robots[this.chosen]?.truth;
    if (pose && isPressed(this.follow)) this.plan.follow([pose[0], pose[1]]);
    this.plan.drawOver();
    this.touch.showLeads();
  }

  /** The moment that is shown, for the view in 3-D: with the same layers. */
  thoughts(moment: Moment): Thoughts {
    const { shown, hidden } = this.layers;
    return {
      time: moment.time,
      robots: moment.robots,
      facts: this.robots,
      trails: (name) => this.record.of(name).trails,
      past: (name, robot) => this.past.of(name, robot),
      shown,
      hidden,
    };
  }

  clear(): void {
    this.moment = null;
    this.past.clear();
    if (this.takeAway([])) this.plan.refresh();
    this.plan.drawOver();
  }

  key(event: KeyboardEvent): boolean {
    if (event.key === "f" || event.key === "F") {
      this.follow.click();
      return true;
    }
    return this.plan.key(event);
  }

  private joints(): Joints {
    return { facts: this.facts, grips: this.moment?.grips ?? [], rows: this.moment?.joints ?? {} };
  }

  /** The robots where they truly are. */
  private standing(): Standing[] {
    return this.robots.flatMap((robot) => {
      const tick = this.moment?.robots[robot.name];
      return tick ? [{ ...robot, pose: tick.truth, tick }] : [];
    });
  }

  /** Show faintly what is away; true when that has changed. */
  private takeAway(names: string[]): boolean {
    if (names.length === this.removed.size && names.every((name) => this.removed.has(name))) return false;
    this.removed = new Set(names);
    const gone = this.plan.items.filter((item) => item.name !== null && this.removed.has(item.name));
    this.plan.looks = new Map(gone.map((item) => [keyOf(item.path), { gone: true }]));
    return true;
  }

  /** Set aside where things stand that have moved; true when one has. */
  private move(things: Record<string, PlanarPose>): boolean {
    let moved = false;
    for (const [name, [x, y, heading]] of Object.entries(things)) {
      const short = name.slice(name.indexOf("/") + 1);
      const before = this.plan.stands.get(short);
      const heading_deg = (heading * 180) / Math.PI;
      const near = before && Math.hypot(before.at[0] - x, before.at[1] - y) < 1e-3;
      if (near && Math.abs(before.heading_deg - heading_deg) < 0.1) continue;
      this.plan.stands.set(short, { at: [x, y], heading_deg });
      moved = true;
    }
    return moved;
  }

  /** Set aside how people and mechanisms stand that have moved; true when one has begun to, or no longer does. */
  private pose(moved: Record<string, Point[][]>): boolean {
    const gone = [...this.posed].filter((name) => !moved[name]);
    for (const name of gone) this.plan.stands.delete(name);
    const fresh = Object.keys(moved).some((name) => !this.posed.has(name));
    for (const item of this.plan.items) {
      const parts = (item.kind === "person" || item.kind === "mechanism") && item.name && moved[item.name];
      if (!parts || !item.name || !item.at) continue;
      this.plan.stands.set(item.name, { at: item.at, heading_deg: item.heading_deg ?? 0, polygons: parts });
    }
    this.posed = new Set(Object.keys(moved));
    return fresh || gone.length > 0;
  }

  private setFollow(on: boolean): void {
    if (on && this.plan.view.scale < CLOSE) {
      this.plan.zoomAt(CLOSE / this.plan.view.scale);
    }
    if (this.moment) this.show(this.moment);
  }

  private fit(): void {
    setPressed(this.follow, false);
    this.plan.fit();
  }

  private draw(context: CanvasRenderingContext2D): void {
    const { left, top, scale } = this.plan.view;
    const { shown, hidden } = this.layers;
    const view = { x: left, y: top, scale };
    const overlay = new Overlay(context, view, shown, this.names);
    const evidence = new Evidence(context, view, this.grids, hidden);
    const ticks = this.robots.flatMap((robot) => {
      const tick = this.moment?.robots[robot.name];
      return tick ? [[robot, tick] as const] : [];
    });
    for (const [robot, tick] of ticks) {
      if (shown.show) evidence.shown(tick);
      if (shown.scans) for (const each of this.past.of("scans", robot.name)) evidence.scans(each);
      if (shown.ring) for (const each of this.past.of("ring", robot.name)) evidence.ring(robot, each);
      if (shown.contacts) evidence.contacts(robot, tick);
    }
    for (const robot of this.robots) overlay.trails(this.record.of(robot.name).trails, this.moment?.time ?? 0);
    for (const [robot] of shown.sightings ? ticks : [])
      for (const each of this.past.of("sightings", robot.name)) overlay.sightings(each);
    for (const [robot, tick] of ticks) overlay.robot(robot, tick, { named: this.robots.length > 1 });
    if (shown.truth)
      for (const { name, arms } of this.robots)
        for (const arm of arms) overlay.arm(this.moment?.bodies?.[`${name}/${arm.name}`] ?? []);
  }
}

function legend(): HTMLElement {
  const entries = [
    ["truth", word("run.truthDrawn")],
    ["estimate", word("charts.estimate")],
    ["odometry", word("charts.odometry")],
    ["seen", word("run.landmarksSightings")],
  ] as const;
  return el(
    "span",
    { class: "run-legend" },
    ...entries.map(([token, label]) => el("span", {}, el("i", { style: `background: var(--${token})` }), label)),
  );
}
