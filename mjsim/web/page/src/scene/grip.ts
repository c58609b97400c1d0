/** What the view in 3-D and the tools of the plan tell each other about handles. */

import type { Point } from "../api";
import type { HeldJoint } from "../run/joint_grips";

/** By which handles a thing is held in 3-D. */
export interface Grip {
  /** Its middle, world frame [m]. */
  at: Point;
  /** Directions along which it is shifted [deg]; one: it slides, two: it goes anywhere as well. */
  axes: number[];
  /** Where it looks [deg]; null: it cannot be turned. */
  heading: number | null;
  lift: boolean;
}

/** x, y, z [m]. */
export type Place = [number, number, number];

/** A tool of an arm, a hand or a joint that can be led. */
export interface Lead {
  key: string;
  /** The body in whose frame its place is. */
  body: string;
  /** x, y and heading of that frame where no body that moves has this name [m, rad]. */
  stands: Place;
  at: Place;
  /** What is written beside it. */
  note?: string | undefined;
  /** Of a joint: how it moves. */
  joint?: HeldJoint;
}

/** Where one is led: while it is dragged, when it is let go, and back to where it was when it is given up. */
export interface Led {
  key: string;
  phase: "drag" | "up" | "cancel";
  /** In the same frame as its place. */
  to: Place;
  /** Of a joint: what its value is then. */
  joint?: HeldJoint;
}

/** A robot or a movable thing that can be put elsewhere. */
export interface LooseThing {
  name: string;
  at: Point;
}

/** Where one is put. */
export interface Put {
  name: string;
  to: Point;
}

/** One moment of a drag by a handle. */
export interface Pull {
  kind: "move" | "turn" | "lift";
  phase: "drag" | "up" | "cancel";
  /** Where it was taken and where it is now, on the level, world frame [m]. */
  from: Point;
  to: Point;
  /** How far up [m]. */
  rise: number;
  /** It goes along one direction only. */
  along: boolean;
  /** Whether it does not snap. */
  alt: boolean;
}
