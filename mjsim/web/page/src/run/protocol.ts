/** What page and server say to each other about a run. Made by scripts/make/protocol.py; do not edit. */

/** An arm of a robot. */
export interface ArmFacts {
  name: string;
  joints: JointFacts[];
}

/** An arm at one tick. */
export interface ArmTick {
  /** Of its joints [rad, m]. */
  positions: number[];
  /** Where they are to be [rad, m]. */
  goal: number[];
  /** x, y, z [m], roll, pitch, yaw about fixed axes [rad], in the robot's frame. */
  tool: number[];
}

/** A camera of a robot. */
export interface CameraFacts {
  name: string;
  /** [px] */
  width: number;
  /** [px] */
  height: number;
}

/** Which modules drive a robot: what `use:` says, null for none. */
export interface Chosen {
  observer: string | null;
  estimator: string | null;
  navigator: string | null;
  avoidance: boolean | string;
}

/** Something that happened to a robot or to the world. */
export interface EventNews {
  kind: "event";
  /** Simulated [s]. */
  time: number;
  /** null: to the world. */
  robot: string | null;
  event: string;
  text: string;
}

/** What stands before a picture, or before where bodies are. */
export interface FrameHead {
  number: number;
  /** `ROBOT/CAMERA`, the same with `:depth` or `:segmentation`, `outside`, or `bodies`. */
  view: string;
  /** Simulated [s]. */
  time: number;
  recognised: Recognised[];
  /** Distances at the near and the far end of the colours of a picture of depth [m]. */
  scale?: [number, number];
}

/** An item of a world as the plan, the panel and the outline show it. */
export interface Item {
  path: (string | number)[];
  kind: string;
  name: string | null;
  label: string;
  at: [number, number] | null;
  heading_deg: number | null;
  /** Outlines in the world frame [m]. */
  polygons: [number, number][][];
  values: Record<string, unknown>;
  written: string[];
  /** As it stands in the text: before defaults, presets and arithmetic. */
  raw?: Record<string, unknown>;
  /** Keys whose values are arithmetic; those cannot be set from here. */
  computed?: string[];
  /** Name of its definition in the schema. */
  type: string;
  /** Why it cannot be changed here. */
  fixed: string | null;
  /** Where it comes from when it is no item of the text itself. */
  origin: "repeat" | "include" | null;
  line: number;
}

/** A joint of an arm. */
export interface JointFacts {
  name: string;
  slides: boolean;
  /** [rad], or [m] where it slides; null without a limit. */
  lower: number | null;
  upper: number | null;
}

/** By which point a hand moves a joint; all in the world frame [m]. */
export interface JointGrip {
  /** `ROBOT/ARM`, or the mechanism. */
  of: string;
  joint: string;
  slides: boolean;
  /** A point of its axis. */
  at: [number, number, number];
  /** About which, or along which, its value grows. */
  axis: [number, number, number];
  /** What the hand takes. */
  grip: [number, number, number];
}

/** Position [rad, m], velocity [1/s], torque or force at the joint [N m, N]. */
export type JointRow = [number | null, number | null, number | null];

/** Mean x, y [m], then covariance xx, xy, yy [m^2]. */
export type LandmarkRow = [number, number, number, number, number];

/** A mechanism, and the joints of it that motions lead. */
export interface MechanismFacts {
  name: string;
  joints: JointFacts[];
}

/** A mechanism at one tick. */
export interface MechanismTick {
  /** Of the joints that motions lead [rad, m]. */
  positions: number[];
}

export type News = RunNews | SceneNews | PastNews | TickNews | EventNews | RefusedNews | ShortNews;

/** A figure of the world that may be changed while it runs. */
export interface NoiseFigure {
  key: string;
  label: string;
  /** null: nothing is said, and there is none. */
  value: number | null;
  /** What the world says. */
  initial: number | null;
  unit: string | null;
  description: string | null;
  /** Both ends of the useful part of its range; null: the unit is enough to choose one. */
  slider: number[] | null;
}

/** All that was until now, for browsers that come late. */
export interface PastNews {
  kind: "past";
  robots: Record<string, TrackHistory>;
  events: EventNews[];
}

export type Pixel = [number, number];

/** x, y [m] and heading [rad, counter-clockwise from x]. */
export type PlanarPose = [number, number, number];

/** Name and corners [px] of a beacon in a picture. */
export type Recognised = [string | null, Pixel[]];

/** A request that was refused. */
export interface RefusedNews {
  kind: "refused";
  do: string;
  error: string;
  /** Code that the person has not allowed yet: files with the SHA-256 of their content, installed classes with ''. */
  needs_trust?: Record<string, string>;
}

/** What is shown of a robot that does not change. */
export interface RobotFacts {
  name: string;
  /** [m] */
  radius: number;
  /** Of its footprint, in its own frame [m]. */
  outline: [number, number][] | null;
  /** From its origin to where the rays of the ring begin, the first one ahead, counter-clockwise [m]. */
  rims: number[];
  color: string | null;
  cameras: CameraFacts[];
  /** Whether it has a drive. */
  can_drive: boolean;
  can_strafe: boolean;
  arms: ArmFacts[];
}

/** One robot at one tick. */
export interface RobotTick {
  truth: PlanarPose;
  estimate: PlanarPose;
  odometry: PlanarPose;
  /** Of x, y, heading, row by row. */
  covariance: number[];
  landmarks: Record<string, LandmarkRow>;
  sightings: SightingRow[];
  /** Distance of the estimate from the truth [m]. */
  error: number;
  /** [rad] */
  heading_error: number;
  /** Null where the covariance is singular, or no estimator there. */
  nees: number | null;
  /** Whether an estimator gives the estimate; else it is dead reckoning. */
  estimated: boolean;
  /** [ms] */
  timing: Record<string, number>;
  /** Forward, left [m/s], turn [rad/s]. */
  command: [number, number, number];
  /** Ranges of the ring, the first one ahead, counter-clockwise [m]; null for nothing near. */
  proximity?: (number | null)[];
  /** What was recognised in its pictures; of recordings alone. */
  recognised?: Recognised[];
  /** Bearings of contacts now [rad]. */
  bump?: number[];
  /** By name. */
  arms?: Record<string, ArmTick>;
  /** Where the beams of each lidar met something: x, y, z of one after the other, world frame [m]. */
  scans?: Record<string, number[]>;
  /** What the estimator shows; left out for nothing. */
  show?: ShownNews[];
}

/** What the run is and does. */
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
  /** Simulated seconds per second that are wanted; null for as fast as it goes. */
  speed: number | null;
  robots: RobotFacts[];
  /** Those of which a joint can be led by hand. */
  mechanisms?: MechanismFacts[];
  /** All joints: of arms by `ROBOT/ARM`, of balancing bases by `ROBOT/drive`, of mechanisms by their names. */
  joints?: Record<string, JointFacts[]>;
  controllable: boolean;
  recording?: string | null;
  drivers?: Record<string, Chosen>;
  noise?: NoiseFigure[];
  /** What was done by hand since the start, as events of a world file. */
  touched?: Record<string, unknown>[];
}

export type RunState = "idle" | "loading" | "running" | "paused" | "ended" | "failed";

/** What a plan of the run's world shows. */
export interface SceneNews {
  kind: "scene";
  items: Item[];
  bounds: [number, number, number, number];
}

/** A hand that was led by the page does not reach its target. */
export interface ShortNews {
  kind: "short";
  person: string;
  /** left or right. */
  hand: string;
  /** How far it stays away [m]. */
  metres: number;
}

/** Something that an estimator shows: points, lines, a grid or a text; which it is, its keys tell. */
export interface ShownNews {
  name: string;
  /** Of its numbers: the world, the robot as estimated, or as it truly is. */
  frame: "world" | "estimate" | "base";
  color: string;
  /** x, y, z of one after the other; of a text where it stands [m]. */
  points?: number[];
  /** The same, of lines through them. */
  lines?: number[];
  /** Whether each point of lines is joined to the next; else every two are a line. */
  joined?: boolean;
  /** Across a point, a line or a cell [m]. */
  size?: number;
  text?: string;
  /** Cells of a grid as grey levels, the first row at the top: 0 occupied to 254 free, 255 unknown; base64. */
  png?: string;
  /** Of the lower left corner of a grid. */
  origin?: PlanarPose;
  /** Columns and rows of a grid. */
  cells?: [number, number];
}

/** Name, null when anonymous; horizontal range [m]; bearing [rad, left positive]. */
export type SightingRow = [string | null, number, number];

/** One tick of the loop. */
export interface TickNews {
  kind: "tick";
  number: number;
  /** Simulated [s]. */
  time: number;
  /** Simulated seconds per second. */
  pace: number;
  robots: Record<string, RobotTick>;
  /** Where everything is that can move but robots, by its name in the scene. */
  things: Record<string, PlanarPose>;
  /** Those that have a joint that a motion leads, by name. */
  mechanisms?: Record<string, MechanismTick>;
  /** Where the grips of people are, by person and side [m]; left out where there is nobody. */
  hands?: Record<string, Record<string, [number, number, number]>>;
  /** Outlines from above of people whose hands were led, the lowest part first [m]; left out for none. */
  people?: Record<string, [number, number][][]>;
  /** How joints move, by arm, base or mechanism and by their names; left out where there are none. */
  joints?: Record<string, Record<string, JointRow>>;
  /** Outlines from above of arms, and of mechanisms that do not stand as at the start, the lowest part first [m]. */
  bodies?: Record<string, [number, number][][]>;
  /** By which points joints are moved by hand. */
  grips?: JointGrip[];
  /** Names of the beacons and obstacles that are away; left out for none. */
  removed?: string[];
}

/** Path and figures of one robot; all lists are equally long. */
export interface TrackHistory {
  time: number[];
  truth: PlanarPose[];
  estimate: PlanarPose[];
  odometry: PlanarPose[];
  /** Standard deviations of x, y [m] and heading [rad]. */
  sigma: PlanarPose[];
  /** Distance of the estimate from the truth [m]. */
  error: (number | null)[];
  /** [rad] */
  heading_error: (number | null)[];
  /** Null where the covariance is singular, or no estimator there. */
  nees: (number | null)[];
  /** Whether an estimator gives the estimate; else it is dead reckoning. */
  estimated: boolean;
  /** Wall-clock time of each module [ms]. */
  timing: Record<string, (number | null)[]>;
}

/** Drive a robot by hand, as fractions of its limits; null releases control. */
export interface DriveByHand {
  do: "drive";
  robot: string;
  forward?: number | null;
  left?: number | null;
  turn?: number | null;
}

/** A picture has been shown: another may come. */
export interface FrameShown {
  do: "shown";
  number: number;
}

/** From where the view from outside looks. */
export interface Outside {
  azimuth_deg: number;
  elevation_deg: number;
  distance: number;
  at: [number, number];
}

/** Change the noise of something. */
export interface SetNoise {
  do: "set";
  key: string;
  value: number;
}

/** Go at a multiple of real time. */
export interface SetSpeed {
  do: "speed";
  value?: number | null;
}

/** A request without arguments. */
export interface Simple {
  do: "pause" | "go" | "tick" | "restart" | "stop";
}

/** Begin a run of a world's text. */
export interface Start {
  do: "start";
  path?: string | null;
  text: string;
  seed?: number | null;
  seconds?: number | null;
  speed?: number | null;
  drivers?: Record<string, Record<string, unknown>>;
  record?: string | null;
}

/** Let an event of the world file happen at the next tick; a paused run takes that tick. */
export interface Touch {
  do: "touch";
  event: Record<string, unknown>;
}

/** Choose the views that are sent. */
export interface Watch {
  do: "watch";
  cameras?: string[];
  depth?: boolean;
  segmentation?: boolean;
  outside?: Outside | null;
  bodies?: boolean;
}

export type RunRequest = Start | Simple | SetSpeed | DriveByHand | Touch | SetNoise | Watch | FrameShown;
