/** Touching a run on its plan: robots and things are dragged elsewhere or pushed, by pointer and by keys. */

import type { Item, Point, Values } from "../api";
import { add, distance, length, minus, times } from "../plan/geometry";
import type { Spot, Tool } from "../plan/gestures";
import type { Plan } from "../plan/plan";
import type { Door } from "../scene/door";
import { isPressed, setPressed, toggle } from "../ui/controls";
import { icon } from "../ui/icons";
import { Signal } from "../ui/signal";
import { word } from "../words/words";
import {
  type Change,
  changeTo,
  goesOn,
  gripAfter,
  type HeldJoint,
  heldJoints,
  isFrozen,
  isStill,
  type Joints,
  jointAfter,
  jointEvent,
  letGoOf,
  rankOf,
  stepped,
  still,
} from "./joint_grips";
import type { Leader } from "./leader";
import type { PlanarPose, RobotFacts, RobotTick, ShortNews } from "./protocol";
import { drawGrab, type Grab, letters, PER_METRE } from "./touch_draw";
import { openTouchMenu } from "./touch_menu";
import {
  drawTools,
  type Hands,
  type Held,
  handLeads,
  jointLeads,
  ledEvent,
  reachEvent,
  toolLeads,
  toolsOf,
} from "./touch_tools";

/** The pointer may slip so far and it is still a click [px]. */
const SLIP = 4;
/** A joint of a loop is led anew if its value differs by more [rad, m]. */
const SETTLED = 0.004;
/** An arrow key takes what is held so far; with Shift a tenth of it [m]. */
const STEP = 0.1;
const ARROWS: Record<string, Point> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

/** What can be put elsewhere: a robot or a movable thing, as it stands now. */
export interface Touchable {
  name: string;
  at: Point;
  heading_deg: number;
  /** [m] */
  radius: number;
  /** Of a tool, a hand or a joint, whose it is. */
  held?: Held;
}

/** A robot where it truly is. */
export type Standing = RobotFacts & { pose: PlanarPose; tick: RobotTick };

/** What the plan of a run knows. */
export interface Floorplan {
  readonly plan: Plan;
  robots(): Standing[];
  hands(): Hands;
  joints(): Joints;
  removed(): ReadonlySet<string>;
}

export class Touch implements Tool {
  /** Switches it on and off. */
  readonly button = toggle(
    { class: "quiet square", title: word("run.touchDragRobotsAndThings"), hidden: true },
    false,
    (on) => this.hold(on),
    icon("touch"),
  );
  /** Told before it takes the plan. */
  readonly taken = new Signal();
  /** A press met none of what can be led or dragged, but things of these names. */
  readonly missed = new Signal<string[]>();
  private solids: Door | null = null;
  /** How far hands and tools stay away from where they were led [m], by person and side or robot and arm. */
  private readonly short = new Map<string, number>();
  private enabled = false;
  /** The joint that was led last, where it was led to. */
  private settled: HeldJoint | null = null;
  /** Whether the view in 3-D has handles, or may have. */
  private hasLeads = false;
  private grab: Grab | null = null;

  constructor(
    private readonly floor: Floorplan,
    private readonly leader: Leader,
  ) {
    floor.plan.overlay.push((context) => this.draw(context));
    floor.plan.menuAsked = (spot, at) => this.enabled && this.menu(spot, at);
  }

  /** Whether there is a run that can be touched. */
  enable(on: boolean): void {
    if (on === this.enabled) return;
    this.enabled = on;
    this.button.hidden = !on;
    this.short.clear();
    if (!on) this.hold(false);
  }

  /** A hand or a tool stays away from where it was led. */
  staysAway({ of, part, metres }: ShortNews): void {
    this.short.set(`${of}/${part}`, metres);
    this.floor.plan.drawOver();
    this.showLeads();
  }

  /** What was touched is where it was led, or no longer led. */
  reached(event: Values): void {
    const there = this.short.delete(
      `${String(event["reach"] ?? event["release"])}/${String(event["hand"] ?? event["arm"])}`,
    );
    if (!there) return;
    this.floor.plan.drawOver();
    this.showLeads();
  }

  private readonly noteOf = (key: string): string | undefined => {
    const metres = this.short.get(key);
    return metres === undefined ? undefined : word("run.metresShort", { metres: metres.toFixed(2) });
  };

  private readonly send = (event: Values): void => this.leader.touch(event);

  /** Have handles in a view in 3-D too. */
  leadIn(solids: Door): void {
    this.solids = solids;
    solids.chosen.on((item) => isPressed(this.button) && this.missed.emit(item?.name ? [item.name] : []));
    solids.led.on((led) => {
      const event = led.joint ? this.jointEvent(led.joint) : ledEvent(led);
      if (led.phase === "drag") this.leader.lead(event);
      else if (led.phase === "up" || this.leader.leads) this.leader.end(event);
    });
    solids.put.on(({ name, to }) => this.send({ move: name, to: to.map(rounded) }));
  }

  /** Put those handles where tools are now. */
  showLeads(): void {
    const { floor } = this;
    const on = isPressed(this.button);
    if (!on && !this.hasLeads) return;
    const leads = on
      ? [
          ...toolLeads(floor.robots(), this.noteOf),
          ...handLeads(floor.hands(), this.noteOf),
          ...jointLeads(this.joints()),
        ]
      : [];
    const isShown = this.solids?.lead(leads, on ? this.draggable() : []) ?? false;
    this.hasLeads = on || !isShown;
    this.goAlong();
  }

  /** What is held stays under a pointer that rests while its robot drives on; a joint of a loop comes nearer. */
  private goAlong(): void {
    const { grab } = this;
    const comesNearer = grab?.joint?.grip.toward !== undefined;
    if (grab?.letGo && !this.leader.leads) this.grab = null;
    if (!grab || !this.leader.leads || (!comesNearer && this.stands(grab) === grab.stood)) return;
    this.take(grab, grab.to);
    if (grab.joint && grab.letGo && !goesOn(grab.joint, grab.by, grab.letGo)) return this.finish();
    this.lead(grab);
  }

  private joints(): HeldJoint[] {
    return heldJoints(this.floor.joints());
  }

  private ticks(): Record<string, RobotTick> {
    return Object.fromEntries(this.floor.robots().map(({ name, tick }) => [name, tick]));
  }

  private jointEvent(held: HeldJoint): Values {
    const { settled } = this;
    // Steps towards the pointer end where they hardly differ.
    if (
      held.grip.toward &&
      this.leader.leads &&
      settled &&
      isSame(held, settled) &&
      Math.abs(held.value - settled.value) < SETTLED
    )
      held = settled;
    this.settled = held;
    return jointEvent(held, this.floor.joints().facts, this.ticks());
  }

  private tools(): Touchable[] {
    return toolsOf(this.floor.robots(), this.floor.hands(), this.joints());
  }

  down(spot: Spot): boolean {
    if (this.grab?.letGo) this.finish();
    const thing = this.thingAt(spot);
    if (!thing) this.missed.emit(this.floor.plan.itemsAt(spot.screen).flatMap(({ name }) => name ?? []));
    if (!thing) return false;
    this.grab = grabbed(thing, spot.world, spot.shift && !thing.held);
    return true;
  }

  drag(spot: Spot): void {
    const { grab, leader } = this;
    if (!grab?.from) return;
    this.take(grab, add(grab.thing.at, minus(spot.world, grab.from)));
    if (leader.leads || distance(spot.world, grab.from) > this.floor.plan.px(SLIP)) this.lead(grab);
    this.floor.plan.drawOver();
  }

  /** Take what is held to a place; a joint as near to it as it can be. */
  private take(grab: Grab, to: Point): void {
    grab.to = to;
    if (!grab.joint) return;
    grab.joint = this.joints().find((each) => isSame(each, grab.joint) && !isFrozen(each.grip)) ?? grab.joint;
    grab.by = changeTo(grab.joint, ([x, y]) => [x, y], to);
  }

  /** Let what is held follow. */
  private lead(grab: Grab): void {
    const event = grab.thing.held && this.heldEvent(grab);
    if (!event) return;
    grab.stood = this.stands(grab);
    this.leader.lead(event);
  }

  /** Where the robot stands that carries what is held. */
  private stands({ thing: { held } }: Grab): string {
    if (!held || "person" in held) return "";
    const name = "grip" in held ? held.grip.of.split("/")[0] : held.robot.name;
    const pose = this.floor.robots().find((robot) => robot.name === name)?.pose ?? [];
    return pose.map((value) => value.toFixed(3)).join();
  }

  /** The event that takes a tool, a hand or a joint where it is to be. */
  private heldEvent({ thing: { held }, to, joint, by }: Grab): Values | null {
    if (joint) return this.jointEvent(jointAfter(joint, by));
    if (!held || "grip" in held) return null;
    if ("person" in held) return reachEvent(held, to);
    const robot = this.floor.robots().find(({ name }) => name === held.robot.name) ?? held.robot;
    return reachEvent({ ...held, robot }, to);
  }

  up(spot: Spot): void {
    const { grab } = this;
    if (!grab?.from) return;
    const slipped = this.leader.leads || distance(spot.world, grab.from) > this.floor.plan.px(SLIP);
    grab.letGo = grab.joint && this.leader.leads ? letGoOf(grab.joint, grab.by) : null;
    if (slipped) return grab.letGo ? undefined : this.finish();
    this.cancel();
    this.menu(spot, this.onPage(spot.screen));
  }

  /** Give up what is held; what followed goes back to where it was taken. */
  cancel(): void {
    const { grab, leader } = this;
    this.grab = null;
    const { held } = grab?.thing ?? {};
    const back =
      grab &&
      leader.leads &&
      this.heldEvent({
        ...grab,
        to: grab.thing.at,
        joint: held && "grip" in held ? held : null,
        by: unmoved(grab.thing),
      });
    if (back) leader.end(back);
    else if (grab) leader.drop();
    this.floor.plan.drawOver();
  }

  hover(spot: Spot): void {
    this.floor.plan.host.style.cursor = this.thingAt(spot) ? "grab" : "default";
  }

  /** Keys: T switches it; then Page Down goes from thing to thing, arrows move it, Enter puts it down, M opens its menu. */
  key(event: KeyboardEvent): boolean {
    if (!this.enabled || event.ctrlKey || event.metaKey || event.altKey) return false;
    if (event.key === "t" || event.key === "T") this.button.click();
    else if (!isPressed(this.button) || !this.heldKey(event)) return false;
    event.preventDefault();
    return true;
  }

  private heldKey({ key, shiftKey }: KeyboardEvent): boolean {
    const { grab } = this;
    const way = ARROWS[key];
    if (key === "PageDown" || key === "PageUp") this.next(key === "PageDown" ? 1 : -1);
    else if (!grab) return false;
    else if (way) this.nudge(grab, way, shiftKey ? 0.1 : 1);
    else if (key === "Enter") this.finish();
    else if (key === "Escape") this.cancel();
    else if (key === "m" || key === "M" || (key === "F10" && shiftKey)) this.menuOf(grab.thing);
    else return false;
    this.floor.plan.drawOver();
    return true;
  }

  /** Take what is held a step on. */
  private nudge(grab: Grab, way: Point, share: number): void {
    const { joint } = grab;
    if (!joint) {
      grab.to = add(grab.to, times(way, share * STEP));
      return;
    }
    grab.by = stepped(joint, grab.by, way, share);
    const [x, y] = gripAfter(joint.grip, grab.by);
    grab.to = [x, y];
  }

  hold(on: boolean): void {
    this.cancel();
    if (on) this.taken.emit();
    setPressed(this.button, on);
    this.floor.plan.tool = on ? this : null;
    this.showLeads();
  }

  private next(step: number): void {
    const things = this.things();
    const first = Math.min(0, -step); // back from nothing is the last one
    const now = Math.max(
      first,
      things.findIndex((thing) => thing.name === this.grab?.thing.name),
    );
    const thing = things[(now + step + things.length) % Math.max(things.length, 1)] ?? things[0];
    if (thing) this.grab = grabbed(thing, null, false);
  }

  private finish(): void {
    const { grab, leader } = this;
    this.grab = null;
    this.floor.plan.drawOver();
    if (!grab) return;
    const way = minus(grab.to, grab.thing.at);
    const event = this.heldEvent(grab);
    if (event) (leader.leads || (grab.joint ? !isStill(grab.by) : length(way) > 0)) && leader.end(event);
    else if (grab.push) this.send({ shove: grab.thing.name, impulse: [...times(way, PER_METRE).map(rounded), 0] });
    else if (length(way) > 0) this.send({ move: grab.thing.name, to: grab.to.map(rounded) });
  }

  private things(): Touchable[] {
    return [...this.tools(), ...this.loose()];
  }

  /** What can be put elsewhere. */
  private draggable(): Touchable[] {
    const fixed = new Set(this.floor.robots().flatMap(({ name, can_drive }) => (can_drive ? [] : [name])));
    return this.loose().filter(({ name }) => !fixed.has(name));
  }

  /** Robots and movable things. */
  private loose(): Touchable[] {
    const { plan } = this.floor;
    const gone = this.floor.removed();
    const robots = this.floor.robots().map(({ name, radius, pose: [x, y, heading] }): Touchable => {
      return { name, at: [x, y], heading_deg: (heading * 180) / Math.PI, radius };
    });
    const movable = plan.items.filter((item) => item.kind === "obstacle" && item.values["movable"] === true);
    const there = movable.flatMap((item) => (item.name && !gone.has(item.name) ? [this.ofItem(item, item.name)] : []));
    return [...robots, ...there];
  }

  private ofItem(item: Item, name: string): Touchable {
    const stand = this.floor.plan.standOf(item);
    const at = stand?.at ?? item.at ?? [0, 0];
    const reach = item.polygons.flat().map((point) => distance(point, item.at ?? [0, 0]));
    return { name, at, heading_deg: stand?.heading_deg ?? item.heading_deg ?? 0, radius: Math.max(0.05, ...reach) };
  }

  private thingAt({ world, screen }: Spot): Touchable | null {
    const { plan } = this.floor;
    const things = this.things();
    const robots = new Set(this.floor.robots().map((robot) => robot.name));
    const under = plan.itemsAt(screen).map((item) => item.name);
    const near = (thing: Touchable): boolean =>
      thing.held || robots.has(thing.name)
        ? distance(thing.at, world) <= Math.max(thing.radius, plan.px(12))
        : under.includes(thing.name);
    const order = (a: Touchable, b: Touchable): number =>
      rank(a) - rank(b) || distance(a.at, world) - distance(b.at, world);
    // Of handles that lie on each other those of joints come last.
    return things.filter((thing) => thing.held && near(thing)).sort(order)[0] ?? things.find(near) ?? null;
  }

  private menu(spot: Spot, at: Point): void {
    const { plan } = this.floor;
    // A door that stands open is found in its opening too.
    const doors = plan.items.filter(({ kind, values, at: middle }) => {
      const half = Number(values["width"]) / 2;
      return kind === "opening" && middle !== null && distance(middle, spot.world) <= Math.max(half, plan.px(10));
    });
    const items = [...plan.itemsAt(spot.screen), ...doors];
    openTouchMenu({ thing: this.thingAt(spot), items, removed: this.floor.removed() }, this.send, at);
  }

  private menuOf(thing: Touchable): void {
    const at = this.onPage(this.floor.plan.view.toScreen(thing.at));
    openTouchMenu({ thing, items: [], removed: this.floor.removed() }, this.send, at);
  }

  private onPage([x, y]: Point): Point {
    const box = this.floor.plan.host.getBoundingClientRect();
    return [box.left + x, box.top + y];
  }

  /** Handles of what can be led, and what is held. */
  private draw(context: CanvasRenderingContext2D): void {
    const { view, palette } = this.floor.plan;
    if (isPressed(this.button)) {
      const tools = this.tools();
      drawTools(context, tools, view, palette);
      for (const { name, at } of tools) letters(context, this.noteOf(name) ?? "", view.toScreen(at), palette);
    }
    const { grab } = this;
    if (!grab) return;
    const now = grab.push ? null : this.things().find(({ name }) => name === grab.thing.name);
    drawGrab(context, grab, now?.at ?? grab.thing.at, this.floor.plan);
  }
}

function grabbed(thing: Touchable, from: Point | null, push: boolean): Grab {
  const joint = thing.held && "grip" in thing.held ? thing.held : null;
  return { thing, to: thing.at, from, push, joint, by: unmoved(thing), stood: "" };
}

function isSame({ grip }: HeldJoint, other: HeldJoint | null): boolean {
  return grip.of === other?.grip.of && grip.joint === other.grip.joint;
}

function unmoved({ held }: Touchable): Change {
  return held && "grip" in held ? still(held) : 0;
}

function rank({ held }: Touchable): number {
  return held && "grip" in held ? rankOf(held.grip) : 0;
}

/** To the millimetre. */
function rounded(value: number): number {
  return Math.round(value * 1000) / 1000;
}
