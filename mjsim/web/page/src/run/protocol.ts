/** What page and server say to each other about a run, over the WebSocket at `/api/run`. */

import type { Item } from "../api";

/** Position in the world frame [m] and heading [rad, counter-clockwise from x]. */
export type Pose = [x: number, y: number, heading: number];

/** A landmark's mean [m] and covariance [m^2]. */
export type Landmark = [x: number, y: number, cxx: number, cxy: number, cyy: number];

/** Name, null when anonymous; horizontal range [m]; bearing [rad, left positive]. */
export type Sighting = [name: string | null, range: number, bearing: number];

export interface CameraInfo {
  name: string;
  width: number;
  height: number;
}

export interface RobotFacts {
  name: string;
  /** [m] */
  radius: number;
  /** Of its footprint, in its own frame [m]. */
  outline: [number, number][] | null;
  color: string | null;
  cameras: CameraInfo[];
  can_strafe: boolean;
}

export type RunState = "idle" | "loading" | "running" | "paused" | "ended" | "failed";

/** Which modules drive a robot: what `use:` says, null for none. */
export interface Chosen {
  observer: string | null;
  estimator: string | null;
  navigator: string | null;
  avoidance: boolean | string;
}

/** A figure of the world that may be changed while it runs. */
export interface Noise {
  key: string;
  /** null: nothing is said, and there is none. */
  value: number | null;
  /** What the world says. */
  initial: number | null;
  unit: string | null;
  description: string | null;
}

export interface RunNews {
  kind: "run";
  state: RunState;
  error?: string | null;
  path: string | null;
  name: string | null;
  /** Simulated [s]. */
  time: number;
  /** How long it is to be [s]; null without end. */
  seconds: number | null;
  /** One tick [s]. */
  dt: number;
  seed: number | null;
  /** Simulated seconds a second that are wanted; null for as fast as it goes. */
  speed: number | null;
  robots: RobotFacts[];
  controllable: boolean;
  recording?: string | null;
  drivers?: Record<string, Chosen>;
  noise?: Noise[];
}

export interface SceneNews {
  kind: "scene";
  items: Item[];
  bounds: [number, number, number, number];
}

/** Path and figures of one robot; all lists are equally long. */
export interface Track {
  time: number[];
  truth: Pose[];
  estimate: Pose[];
  odometry: Pose[];
  /** Standard deviations of x, y [m] and heading [rad]. */
  sigma: Pose[];
  nees: (number | null)[];
  /** Wall-clock time of each module [ms]. */
  timing: Record<string, (number | null)[]>;
}

export interface PastNews {
  kind: "past";
  robots: Record<string, Track>;
  events: EventNews[];
}

export interface RobotTick {
  truth: Pose;
  estimate: Pose;
  odometry: Pose;
  /** Of x, y, heading, row by row. */
  covariance: number[];
  landmarks: Record<string, Landmark>;
  sightings: Sighting[];
  /** Distance of the estimate from the truth [m]. */
  error: number;
  /** [rad] */
  heading_error: number;
  nees: number | null;
  /** [ms] */
  timing: Record<string, number>;
  /** Forward, left [m/s], turn [rad/s]. */
  command: [number, number, number];
  /** Ranges of the ring, the first one ahead, counter-clockwise [m]. */
  proximity?: number[];
  /** What was recognised in its pictures, as in `FrameHead`; of recordings alone. */
  recognised?: FrameHead["recognised"];
  /** Bearings of contacts now [rad]. */
  bump?: number[];
}

export interface TickNews {
  kind: "tick";
  number: number;
  time: number;
  /** Simulated seconds a second. */
  pace: number;
  robots: Record<string, RobotTick>;
  things: Record<string, Pose>;
}

export interface EventNews {
  kind: "event";
  time: number;
  robot: string | null;
  event: string;
  text: string;
}

/** An order that could not be obeyed. */
export interface RefusedNews {
  kind: "refused";
  do: string;
  error: string;
  /** Files whose code the person has not allowed yet. */
  needs_trust?: string[];
}

export type News = RunNews | SceneNews | PastNews | TickNews | EventNews | RefusedNews;

/** From where the view from outside looks. */
export interface Outside {
  azimuth_deg: number;
  elevation_deg: number;
  /** [m] */
  distance: number;
  at: [number, number];
}

/** A module and the arguments that it is made with. */
export interface Use {
  use: string;
  [key: string]: unknown;
}

/** Modules that are to replace those of the world; a key that is not there stays as the world has it. */
export interface Driver {
  observer?: Use | null;
  estimator?: Use | null;
  navigator?: Use | null;
  avoidance?: Use | boolean;
}

export type Order =
  | {
      do: "start";
      path: string;
      text: string;
      seed?: number;
      seconds?: number;
      speed: number | null;
      drivers?: Record<string, Driver>;
      record?: string | null;
    }
  | { do: "pause" | "go" | "tick" | "restart" | "stop" }
  | { do: "speed"; value: number | null }
  | { do: "drive"; robot: string; forward: number | null; left: number | null; turn: number | null }
  | { do: "set"; key: string; value: number }
  | { do: "watch"; cameras: string[]; depth: boolean; segmentation: boolean; outside: Outside | null }
  | { do: "shown"; number: number };

/** What stands before a picture. */
export interface FrameHead {
  number: number;
  /** `ROBOT/CAMERA`, the same with `:depth` or `:segmentation`, or `outside`. */
  view: string;
  time: number;
  recognised: [name: string | null, corners: [number, number][]][];
  /** Distances at the ends of the colours of a picture of depth [m]. */
  scale?: [near: number, far: number];
}
