/** Joints that a hand moves on the plan and in 3-D: where their handles are, and which value brings one to a place. */

import type { Point, Values } from "../api";
import type { Place } from "../scene/grip";
import { ballAfter, ballTo, both, rotationAfter, rotationOf } from "./balls";
import { curveAfter, curveTo, isSeenFromAbove } from "./curves";
import { dragged, rounded, shown, unit } from "./joint_units";
import type { JointFacts, JointGrip, JointRow, RobotTick } from "./protocol";
import { crossed, dot, minus, plus, times } from "./rotations";

/** Values of a joint that turns are tried so far apart, all the way round [rad]. */
const TRIED = Math.PI / 90;
/** Then the nearest one is found in so many steps, by slopes over so much [rad, m]. */
const STEPS = 12;
const SLOPE = 1e-4;
/** What turns about an axis, or slides along one, that stands nearer to upright than this does or does not show from above. */
const FLAT = 0.05;
/** A joint in a loop is led so far at once [m, rad]. */
const STRAIGHT = 0.2;
const TURNED = 0.35;
/** A key takes a joint so far [m, rad]. */
const STEP = 0.1;
const TURN = Math.PI / 36;

/** A joint that a hand holds. */
export interface HeldJoint {
  grip: JointGrip;
  facts: JointFacts;
  /** Where it is, or is to be [rad, m]; unused for a ball. */
  value: number;
  /** Of a ball: its rotation vector, as it is or shall be [rad]. */
  rotation?: Place;
}

/** By how much a joint is moved: its value [rad, m], or, of a ball, a rotation vector in the world [rad]. */
export type Change = number | Place;

/** What is known of joints at a moment. */
export interface Joints {
  facts: Record<string, JointFacts[]>;
  grips: JointGrip[];
  rows: Record<string, Record<string, JointRow>>;
}

/** All joints that can be moved, where they are. */
export function heldJoints({ facts, grips, rows }: Joints): HeldJoint[] {
  return grips.flatMap((grip) => {
    const own = facts[grip.of] ?? [];
    const ball = own.find(({ name }) => name === `${grip.joint}.rx`);
    const rotation = grip.ball && rotationOf(grip, rows);
    if (ball && rotation) return [{ grip, facts: ball, value: 0, rotation }];
    const value = rows[grip.of]?.[grip.joint]?.[0];
    const found = own.find(({ name }) => name === grip.joint);
    return found && value != null ? [{ grip, facts: found, value }] : [];
  });
}

/** Whether its motion is seen from above. */
export function showsOnPlan(grip: JointGrip): boolean {
  const {
    slides,
    axis: [x, y, z],
    ball,
    curve,
  } = grip;
  if (ball) return true;
  if (curve) return isSeenFromAbove(grip, FLAT);
  return slides ? Math.hypot(x, y) > FLAT : Math.abs(z) > FLAT;
}

/** Whether its axis moves with it, and how is not known: it is taken to where it was when it was taken. */
export function isFrozen({ loop, toward }: JointGrip): boolean {
  return Boolean(loop && !toward);
}

/** Which of handles that lie on each other is taken: the lowest; a point on a curve before other joints of its body. */
export function rankOf({ curve }: JointGrip): number {
  return curve ? 1 : 2;
}

/** Where the handle is once the joint was moved. */
export function gripAfter(joint: JointGrip, by: Change): Place {
  const { slides, at, axis, grip } = joint;
  if (typeof by !== "number") return ballAfter(joint, by);
  if (joint.curve) return curveAfter(joint, by);
  if (joint.toward) return plus(grip, times(joint.toward, by));
  if (slides) return [grip[0] + by * axis[0], grip[1] + by * axis[1], grip[2] + by * axis[2]];
  const way = minus(grip, at);
  // Rodrigues' formula.
  const [across, along] = [crossed(axis, way), dot(axis, way)];
  const [cos, sin] = [Math.cos(by), Math.sin(by)];
  const turned = (k: 0 | 1 | 2): number => at[k] + way[k] * cos + across[k] * sin + axis[k] * along * (1 - cos);
  return [turned(0), turned(1), turned(2)];
}

/** A joint once it was moved. */
export function jointAfter(held: HeldJoint, by: Change): HeldJoint {
  if (typeof by === "number") return { ...held, value: held.value + by };
  return { ...held, rotation: rotationAfter(held.grip, held.rotation ?? [0, 0, 0], by) };
}

/** No change of a joint. */
export function still({ grip }: HeldJoint): Change {
  return grip.ball ? [0, 0, 0] : 0;
}

export function isStill(by: Change): boolean {
  return typeof by === "number" ? by === 0 : Math.hypot(...by) === 0;
}

/** Move a joint a step on by keys: its value grows to the right and up; a ball turns about the vertical, and tilts. */
export function stepped(held: HeldJoint, by: Change, [right, up]: Point, share: number): Change {
  const { facts, value, grip } = held;
  if (typeof by !== "number") {
    const [x, y] = minus(gripAfter(grip, by), grip.at);
    const level = Math.hypot(x, y);
    const tilt: Place = level > 1e-6 ? [y / level, -x / level, 0] : [0, 1, 0];
    const angle = share * TURN;
    return both(by, [-up * angle * tilt[0], -up * angle * tilt[1], -right * angle]);
  }
  const wanted = value + by + share * (facts.slides ? STEP : TURN) * (right + up);
  return within(wanted, facts) - value;
}

/** The change that takes the handle as near as it can be to a place of a picture. */
export function changeTo({ grip, facts, value }: HeldJoint, draw: (place: Place) => Point, to: Point): Change {
  if (grip.ball) return ballTo(grip, draw, to);
  if (grip.toward) return within(value + towards(grip, draw, to), facts) - value;
  if (grip.curve) return within(value + curveTo(grip, draw, to), facts) - value;
  const missed = (by: number): Point => {
    const [x, y] = draw(gripAfter(grip, by));
    return [x - to[0], y - to[1]];
  };
  const far = (by: number): number => Math.hypot(...missed(by));
  let best = 0;
  for (let by = TRIED; !grip.slides && by <= Math.PI; by += TRIED)
    for (const each of [by, -by]) if (far(each) < far(best) - 1e-9) best = each;
  for (let step = 0; step < STEPS; step++) {
    const [x, y] = missed(best);
    const [u, v] = missed(best + SLOPE);
    const [dx, dy] = [(u - x) / SLOPE, (v - y) / SLOPE];
    const next = best - (x * dx + y * dy) / Math.max(dx * dx + dy * dy, 1e-12);
    if (far(next) >= far(best)) break;
    best = next;
  }
  return within(value + best, facts) - value;
}

/** The step of a joint in a loop that takes its handle nearer: straight on, so no farther than that is nearly right. */
function towards({ grip, toward = [0, 0, 0], slides }: JointGrip, draw: (place: Place) => Point, to: Point): number {
  const [x, y] = draw(grip);
  const [u, v] = draw(plus(grip, times(toward, SLOPE)));
  const [dx, dy] = [(u - x) / SLOPE, (v - y) / SLOPE];
  const by = (dx * (to[0] - x) + dy * (to[1] - y)) / Math.max(dx * dx + dy * dy, 1e-12);
  const most = slides ? STRAIGHT : TURNED;
  return Math.min(Math.max(by, -most), most);
}

/** What is let go goes on to where it was let go for so many ticks at most: a run may go slower than the clock. */
const FLUNG = 100;
/** It is there when the next step is no longer than this [m, rad], for so many ticks. */
const CLOSE = 0.01;
const CALM = 12;

/** A joint that was let go before it was there: how many ticks ago, and for how many it has been there since. */
export interface LetGo {
  ticks: number;
  calm: number;
}

/** Whether, at another tick, a joint of a loop that was let go still has a way to go to where that was, or swings past it. */
export function goesOn({ grip }: HeldJoint, by: Change, letGo: LetGo): boolean {
  if (grip.toward === undefined || typeof by !== "number") return false;
  letGo.ticks += 1;
  letGo.calm = Math.abs(by) > CLOSE ? 0 : letGo.calm + 1;
  return letGo.calm < CALM && letGo.ticks < FLUNG;
}

/** Let a joint go: null where it is there, or is none of a loop. */
export function letGoOf({ grip }: HeldJoint, by: Change): LetGo | null {
  return grip.toward !== undefined && typeof by === "number" && Math.abs(by) > CLOSE ? { ticks: 0, calm: 0 } : null;
}

function within(value: number, { lower, upper }: JointFacts): number {
  return Math.min(Math.max(value, lower ?? value), upper ?? value);
}

/** The event that takes a joint to its value; that of an arm keeps where its other joints shall be. */
export function jointEvent(
  { grip, facts, value, rotation }: HeldJoint,
  all: Record<string, JointFacts[]>,
  robots: Record<string, RobotTick>,
): Values {
  if (rotation) return { lead: grip.of, joint: grip.joint, rotation_deg: rotation.map((each) => dragged(facts, each)) };
  const to_deg = dragged(facts, value);
  const goals = goalsOf(grip, robots);
  if (!goals) return { lead: grip.of, joint: grip.joint, to_deg };
  const [reach, arm] = armOf(grip);
  const own = all[grip.of] ?? [];
  const joints_deg = own.map((each, k) => (each.name === grip.joint ? to_deg : rounded(shown(each, goals[k] ?? 0))));
  return { reach, arm, joints_deg };
}

/** The event that gives a joint, or the arm that it is of, back. */
export function releaseEvent({ of, joint }: JointGrip): Values {
  const [release, arm] = armOf({ of });
  return arm === undefined ? { release, joint } : { release, arm };
}

/** What is written beside a joint that is held. */
export function jointSaid({ grip, facts, value, rotation }: HeldJoint): string[] {
  if (rotation) return [grip.joint, rotation.map((each) => shown(facts, each).toFixed(1)).join(", "), unit(facts)];
  return [grip.joint, shown(facts, value).toFixed(facts.slides ? 3 : 1), unit(facts)];
}

/** Where the joints of its arm shall be; null for one of a mechanism. */
function goalsOf(grip: JointGrip, robots: Record<string, RobotTick>): number[] | null {
  const [robot, arm] = armOf(grip);
  return arm === undefined ? null : (robots[robot]?.arms?.[arm]?.goal ?? null);
}

/** Robot and arm; a mechanism alone. */
function armOf({ of }: { of: string }): [string, string?] {
  const cut = of.indexOf("/");
  return cut < 0 ? [of] : [of.slice(0, cut), of.slice(cut + 1)];
}
