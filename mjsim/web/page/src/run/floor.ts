/** The plan of a run: what stands still, drawn by the plan; what moves, drawn over it. */

import { el } from "../dom";
import type { Bounds, Item } from "../api";
import { Plan } from "../plan/plan";
import { button, isPressed, remembered, setPressed, sign, toggle } from "./controls";
import { Overlay, type Shown } from "./overlay";
import type { PlanarPose, RobotFacts, RobotTick } from "./protocol";
import type { RunRecord } from "./record";
import { makeTile, type Tile } from "./tile";

const LAYERS: [keyof Shown, string][] = [
  ["truth", "Truth"],
  ["estimate", "Estimate"],
  ["odometry", "Odometry"],
  ["trails", "Trails"],
  ["ellipses", "95 % ellipses"],
  ["landmarks", "Landmarks"],
  ["sightings", "Sightings"],
];
/** While following, so much of the world is seen at least [px/m]. */
const CLOSE = 90;

export interface Moment {
  robots: Record<string, RobotTick>;
  things: Record<string, PlanarPose>;
}

export class Floor {
  readonly tile: Tile;
  /** Things may be laid over the plan here. */
  readonly host = el("div", { class: "run-floor", tabindex: 0, role: "group", "aria-label": "Plan; + - and 0 zoom" });
  private readonly plan: Plan;
  private readonly follow: HTMLButtonElement;
  private readonly shown: Shown;
  private robots: RobotFacts[] = [];
  private moment: Moment | null = null;
  private chosen = "";
  private names = new Set<string>();

  constructor(private readonly record: RunRecord) {
    const kept = remembered("run.layers");
    this.shown = Object.fromEntries(
      LAYERS.map(([key]) => [key, kept === null || kept.split(" ").includes(key)]),
    ) as unknown as Shown;
    this.follow = toggle(
      { class: "quiet square", title: "Follow the robot (F)" },
      false,
      (on) => this.setFollow(on),
      sign("follow"),
    );
    const fit = button({ class: "quiet square", title: "Show the whole plan (0)" }, () => this.fit(), sign("fit"));
    this.tile = makeTile(
      "plan",
      "Plan",
      this.host,
      legend(),
      el("span", { class: "run-spring" }),
      this.menu(),
      this.follow,
      fit,
    );
    this.plan = new Plan(this.host);
    this.plan.hiddenKinds.add("robot");
    this.plan.overlay.push((context) => this.draw(context));
  }

  scene(items: Item[], bounds: Bounds): void {
    this.plan.stands.clear();
    const same = bounds.join() === this.plan.bounds.join() && this.names.size > 0;
    this.names = new Set(items.flatMap((item) => item.name ?? []));
    this.plan.setItems(items, bounds);
    if (!same) this.fit();
  }

  run(robots: RobotFacts[], chosen: string): void {
    this.robots = robots;
    this.chosen = chosen;
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
    if (this.move(moment.things)) this.plan.refresh();
    const pose = moment.robots[this.chosen]?.truth;
    if (pose && isPressed(this.follow)) this.plan.follow([pose[0], pose[1]]);
    this.plan.drawOver();
  }

  clear(): void {
    this.moment = null;
    this.plan.drawOver();
  }

  key(event: KeyboardEvent): boolean {
    if (event.key === "f" || event.key === "F") {
      this.follow.click();
      return true;
    }
    return this.plan.key(event);
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
    const overlay = new Overlay(context, { x: left, y: top, scale }, this.shown, this.names);
    for (const robot of this.robots) overlay.trails(this.record.of(robot.name).trails);
    for (const robot of this.robots) {
      const tick = this.moment?.robots[robot.name];
      if (tick) overlay.robot(robot, tick, { named: this.robots.length > 1 });
    }
  }

  private menu(): HTMLElement {
    const boxes = LAYERS.map(([key, label]) => {
      const box = el("input", { type: "checkbox", onchange: () => this.setLayer(key, box.checked) });
      box.checked = this.shown[key];
      return el("label", {}, box, label);
    });
    const list = el("div", { class: "run-menu", role: "group", "aria-label": "What is shown" }, ...boxes);
    const summary = el(
      "summary",
      { class: "button quiet square", title: "What is shown", "aria-label": "What is shown" },
      sign("layers"),
    );
    const details = el("details", { class: "run-layers" }, summary, list);
    document.addEventListener("pointerdown", (event) => {
      if (!details.contains(event.target as Node)) details.open = false;
    });
    details.addEventListener("keydown", (event) => {
      if (event.key === "Escape") details.open = false;
    });
    return details;
  }

  private setLayer(key: keyof Shown, on: boolean): void {
    this.shown[key] = on;
    remembered(
      "run.layers",
      LAYERS.map(([each]) => each)
        .filter((each) => this.shown[each])
        .join(" "),
    );
    this.plan.drawOver();
  }
}

function legend(): HTMLElement {
  const entries = [
    ["truth", "truth"],
    ["estimate", "estimate"],
    ["odometry", "odometry"],
    ["seen", "landmarks, sightings"],
  ] as const;
  return el(
    "span",
    { class: "run-legend" },
    ...entries.map(([token, label]) => el("span", {}, el("i", { style: `background: var(--${token})` }), label)),
  );
}
