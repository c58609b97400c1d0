/** What page and server say to each other about a run. Made by scripts/make/protocol.py; do not edit. */

/** An arm of a robot. */
export interface ArmFacts {
  name: string;
  joints: JointFacts[];
}

/** An arm at one tick. */
export interface ArmTick {
  /** Joint positions [rad, m]. */
  positions: number[];
  /** Goal positions [rad, m]. */
  goal: number[];
  /** x, y, z [m], roll, pitch, yaw about fixed axes [rad], in the robot's frame. */
  tool: number[];
}

/** The frame in which a ball joint has its rotation vector. */
export interface BallFrame {
  /** Its x, y and z axis in the world frame, nine numbers. */
  axes: number[];
  /** 1, or -1 if the rotation is that of the carrying body relative to the carried one. */
  way: number;
}

/** A camera of a robot. */
export interface CameraFacts {
  name: string;
  /** [px] */
  width: number;
  /** [px] */
  height: number;
}

/** Modules that drive a robot: their `use:`, null for none. */
export interface Chosen {
  observer: string | null;
  estimator: string | null;
  navigator: string | null;
  avoidance: boolean | string;
}

/** The current curve along which a point moves. */
export interface CurveFrame {
  /** x, y, z of points at equal distances along it, in sequence, world frame [m]; the last is at its end. */
  points: number[];
  /** [m] */
  length: number;
  closed: boolean;
  /** Position of the point, from the first one [m]. */
  along: number;
}

/** An event that concerns a robot or the world. */
export interface EventNews {
  kind: "event";
  /** Simulated time [s]. */
  time: number;
  /** null: the world. */
  robot: string | null;
  event: string;
  text: string;
  /** Number of a motion; a later event with the same number replaces this one. */
  motion?: number;
}

/** Header of a picture, or of the poses of bodies. */
export interface FrameHead {
  number: number;
  /** `ROBOT/CAMERA`, the same with `:depth` or `:segmentation`, `outside`, or `bodies`. */
  view: string;
  /** Simulated time [s]. */
  time: number;
  recognised: Recognised[];
  /** Distances at the near and the far end of the colour scale of a depth picture [m]. */
  scale?: [number, number];
}

/** An item of a world for the plan, the panel and the outline. */
export interface Item {
  path: (string | number)[];
  kind: string;
  name: string | null;
  label: string;
  at: [number, number] | null;
  heading_deg: number | null;
  /** Outlines in the world frame [m]. */
  polygons: [number, number][][];
  /** What is drawn of it, from the floor up. */
  shapes: PlanShape[];
  values: Record<string, unknown>;
  written: string[];
  /** Its keys as in the text, before defaults, presets and arithmetic. */
  raw?: Record<string, unknown>;
  /** Keys with expressions as values; these cannot be set here. */
  computed?: string[];
  /** Name of its definition in the schema. */
  type: string;
  /** Why it cannot be changed here. */
  fixed: string | null;
  /** Where it comes from, if it is not an item of the text itself. */
  origin: "repeat" | "include" | null;
  line: number;
}

/** A joint of an arm. */
export interface JointFacts {
  name: string;
  slides: boolean;
  /** [rad], or [m] for a sliding joint; null without a limit. */
  lower: number | null;
  upper: number | null;
  /** In a mechanism: whether a hand pulls it against its forces; otherwise the hand replaces its motion. */
  held?: boolean;
  /** Length of the closed curve along which it moves [m]; its position grows with each lap. */
  period?: number;
}

/** The point by which a joint is dragged; all in the world frame [m]. */
export interface JointGrip {
  /** `ROBOT/ARM`, or the mechanism. */
  of: string;
  joint: string;
  slides: boolean;
  /** A point on its axis. */
  at: [number, number, number];
  /** Unit vector of the axis about or along which its value increases. */
  axis: [number, number, number];
  /** The point to drag. */
  grip: [number, number, number];
  /** Frame of a ball joint, which has no axis; omitted for others. */
  ball?: BallFrame;
  /** Curve of a point that slides along it, whose axis is its tangent; omitted for others. */
  curve?: CurveFrame;
  /** In a mechanism with one degree of freedom and loops: how the point moves with the value, as its axis moves too [m, m/rad]. */
  toward?: [number, number, number];
  /** Whether the joint is in a mechanism with loops: its axis may move with its value. */
  loop?: boolean;
}

/** Position [rad, m], velocity [1/s], torque or force at the joint [N m, N]. */
export type JointRow = [number | null, number | null, number | null];

/** Mean x, y [m], then covariance xx, xy, yy [m^2]. */
export type LandmarkRow = [number, number, number, number, number];

/** A mechanism, and the joints of it that can be led. */
export interface MechanismFacts {
  name: string;
  joints: JointFacts[];
}

/** A mechanism at one tick. */
export interface MechanismTick {
  /** Positions of the joints that can be led [rad, m]. */
  positions: number[];
}

export type News = RunNews | SceneNews | PastNews | TickNews | EventNews | RefusedNews | ShortNews | TouchedNews;

/** A parameter of the world that may be changed during a run. */
export interface NoiseFigure {
  key: string;
  label: string;
  /** null: not set, so there is none. */
  value: number | null;
  /** Value in the world. */
  initial: number | null;
  unit: string | null;
  description: string | null;
  /** Useful range for a slider; null: choose one from the unit. */
  slider: number[] | null;
}

/** The history until now, for browsers that join late. */
export interface PastNews {
  kind: "past";
  robots: Record<string, TrackHistory>;
  events: EventNews[];
}

export type Pixel = [number, number];

/** A part of an item's drawing; an area to scale fills polygons of the item, all others have parts of their own. */
export interface PlanShape {
  /** Its look is that of `ROLES`. */
  role: string;
  /** Own colour of the thing, '#rrggbb'. */
  tint?: string;
  /** Strength of its fill, from 0 to 1; 1 if omitted. */
  level?: number;
  /** How many polygons of the item it fills, in turn. */
  count?: number;
  /** Lines, or outlines if `closed`, from the pose of the item [m]. */
  parts?: [number, number][][];
  closed?: boolean;
  /** A symbol of the same size at each scale: its pose from that of the item (x, y [m], heading [deg]); its parts are in millimetres on paper from there. */
  anchor?: [number, number, number];
  /** Whether it stays where it is when the item moves in a run. */
  fixed?: boolean;
  /** Initial pose of what it moves with, world frame (x, y [m], heading [deg]); that of the item if omitted. */
  carrier?: [number, number, number];
}

/** x, y [m] and heading [rad, counter-clockwise from x]. */
export type PlanarPose = [number, number, number];

/** Name and corners [px] of a beacon in a picture. */
export type Recognised = [string | null, Pixel[]];

/** A request that was refused. */
export interface RefusedNews {
  kind: "refused";
  do: string;
  error: string;
  /** Code that the user has not allowed yet: files with the SHA-256 of their content, installed classes with ''. */
  needs_trust?: Record<string, string>;
}

/** Constant properties of a robot. */
export interface RobotFacts {
  name: string;
  /** [m] */
  radius: number;
  /** Footprint, in its own frame [m]. */
  outline: [number, number][] | null;
  /** Distances from its origin to the start of its proximity rays, the first one forward, counter-clockwise [m]. */
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
  /** Covariance of x, y, heading, row by row. */
  covariance: number[];
  landmarks: Record<string, LandmarkRow>;
  sightings: SightingRow[];
  /** Distance of the estimate from the truth [m]. */
  error: number;
  /** Heading error [rad]. */
  heading_error: number;
  /** Null if the covariance is singular, or if there is no estimator. */
  nees: number | null;
  /** Whether an estimator gives the estimate; otherwise it is dead reckoning. */
  estimated: boolean;
  /** [ms] */
  timing: Record<string, number>;
  /** Forward, left [m/s], turn [rad/s]. */
  command: [number, number, number];
  /** Ranges of the proximity rays, the first one forward, counter-clockwise [m]; null for no hit. */
  proximity?: (number | null)[];
  /** What was recognised in its pictures; only for recordings. */
  recognised?: Recognised[];
  /** Bearings of contacts since the last tick [rad]. */
  bump?: number[];
  /** By name of the arm. */
  arms?: Record<string, ArmTick>;
  /** Points hit by the beams of each lidar: x, y, z of each in sequence, world frame [m]. */
  scans?: Record<string, number[]>;
  /** Items that the estimator shows; omitted if there are none. */
  show?: ShownNews[];
}

/** The run and its state. */
export interface RunNews {
  kind: "run";
  /** Counts the runs, from 1; a restart is the same run. Of states that follow fast on each other only the last is certain to arrive. */
  number: number;
  state: RunState;
  error?: string | null;
  path: string | null;
  name: string | null;
  /** Simulated time [s]. */
  time: number;
  /** Planned duration [s]; null without end. */
  seconds: number | null;
  /** Duration of a tick [s]. */
  dt: number;
  seed: number | null;
  /** Requested simulated seconds per second; null for as fast as possible. */
  speed: number | null;
  robots: RobotFacts[];
  /** Mechanisms with a joint that can be dragged. */
  mechanisms?: MechanismFacts[];
  /** All joints: of arms by `ROBOT/ARM`, of balancing bases by `ROBOT/drive`, of mechanisms by name. */
  joints?: Record<string, JointFacts[]>;
  controllable: boolean;
  recording?: string | null;
  drivers?: Record<string, Chosen>;
  noise?: NoiseFigure[];
  /** Manual interventions since the start, as events of a world file. */
  touched?: Record<string, unknown>[];
}

export type RunState = "idle" | "loading" | "running" | "paused" | "ended" | "failed";

/** The plan of the run's world. */
export interface SceneNews {
  kind: "scene";
  items: Item[];
  bounds: [number, number, number, number];
}

/** A hand or tool that the page moved does not reach its target. A hand, and a tool that is dragged, comes as near as it can; otherwise a tool stays where it was. */
export interface ShortNews {
  kind: "short";
  of: string;
  /** left or right for a person's hand, else the arm of a robot. */
  part: string;
  /** Distance to the target [m]. */
  metres: number;
}

/** An item that an estimator shows: points, lines, a grid or a text; its keys show which. */
export interface ShownNews {
  name: string;
  /** Frame of its numbers: the world, the robot as estimated, or the true robot. */
  frame: "world" | "estimate" | "base";
  color: string;
  /** x, y, z of each point in sequence; for a text, its position [m]. */
  points?: number[];
  /** The same for the points of lines. */
  lines?: number[];
  /** Whether consecutive points are connected; otherwise each pair of points is a line. */
  joined?: boolean;
  /** Size of a point, a line or a cell [m]. */
  size?: number;
  text?: string;
  /** Cells of a grid as grey levels, the first row at the top: 0 occupied to 254 free, 255 unknown; base64. */
  png?: string;
  /** Pose of the lower left corner of a grid. */
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
  /** Simulated time [s]. */
  time: number;
  /** Simulated seconds per second. */
  pace: number;
  robots: Record<string, RobotTick>;
  /** Poses of all movable objects except robots, by name in the scene. */
  things: Record<string, PlanarPose>;
  /** Mechanisms with a joint that a motion leads, by name. */
  mechanisms?: Record<string, MechanismTick>;
  /** Grip positions of people, by person and side [m]; omitted without people. */
  hands?: Record<string, Record<string, [number, number, number]>>;
  /** Outlines from above of people whose hands were moved, the lowest part first [m]; omitted if there are none. */
  people?: Record<string, [number, number][][]>;
  /** Motion of joints, by arm, base or mechanism and by name; omitted if there are none. */
  joints?: Record<string, Record<string, JointRow>>;
  /** Outlines from above of arms, and of mechanisms away from their start values, the lowest part first [m]. */
  bodies?: Record<string, [number, number][][]>;
  /** The points by which joints are dragged. */
  grips?: JointGrip[];
  /** Names of removed beacons and obstacles; omitted if there are none. */
  removed?: string[];
}

/** A touch of this page was accepted; a touch is answered with this, `short` or `refused`. */
export interface TouchedNews {
  kind: "touched";
}

/** Path and errors of one robot; all lists have the same length. */
export interface TrackHistory {
  time: number[];
  truth: PlanarPose[];
  estimate: PlanarPose[];
  odometry: PlanarPose[];
  /** Standard deviations of x, y [m] and heading [rad]. */
  sigma: PlanarPose[];
  /** Distance of the estimate from the truth [m]. */
  error: (number | null)[];
  /** Heading error [rad]. */
  heading_error: (number | null)[];
  /** Null if the covariance is singular, or if there is no estimator. */
  nees: (number | null)[];
  /** Whether an estimator gives the estimate; otherwise it is dead reckoning. */
  estimated: boolean;
  /** Wall-clock time of each module [ms]. */
  timing: Record<string, (number | null)[]>;
}

/** Drive a robot manually, as fractions of its limits; null releases control. */
export interface DriveByHand {
  do: "drive";
  robot: string;
  forward?: number | null;
  left?: number | null;
  turn?: number | null;
}

/** A picture has been displayed: another may be sent. */
export interface FrameShown {
  do: "shown";
  number: number;
}

/** Viewpoint of the external view. */
export interface Outside {
  azimuth_deg: number;
  elevation_deg: number;
  distance: number;
  at: [number, number];
}

/** Change a noise parameter. */
export interface SetNoise {
  do: "set";
  key: string;
  value: number;
}

/** Run at a multiple of real time. */
export interface SetSpeed {
  do: "speed";
  value?: number | null;
}

/** A request without arguments. */
export interface Simple {
  do: "pause" | "go" | "tick" | "restart" | "stop";
}

/** Start a run of a world's text. */
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

/** Trigger an event of the world file at the next tick; a paused run executes that tick. */
export interface Touch {
  do: "touch";
  event: Record<string, unknown>;
  drag?: "first" | "next" | null;
}

/** Choose the views to be sent. */
export interface Watch {
  do: "watch";
  cameras?: string[];
  depth?: boolean;
  segmentation?: boolean;
  outside?: Outside | null;
  bodies?: boolean;
}

export type RunRequest = Start | Simple | SetSpeed | DriveByHand | Touch | SetNoise | Watch | FrameShown;

/** Kinds of sensors: keys that name them. */
export const SENSOR_KINDS = ["camera", "lidar", "beacons", "imu", "encoders", "uwb", "lidar3d", "compass"];
