/** What the server knows of a recording. */

import { type Bounds, getBytes, getJson, type Item, postJson } from "../api";
import type { Column, Field, Message, Source } from "../charts/plotter";
import type { EventNews, JointFacts, Outside, RobotFacts, RobotTick, TickNews, TrackHistory } from "../run/protocol";
import type { RecordingCard } from "./facts";

export interface Recording {
  path: string;
  name: string;
  robots: RobotFacts[];
  /** Time of the last tick [s]. */
  seconds: number;
  /** One tick [s]. */
  dt: number;
  seed: number | null;
  /** Size of its file. */
  bytes: number;
  /** Whether it was closed properly; false: it was cut off, or is still being written. */
  whole: boolean;
  scene: { items: Item[]; bounds: Bounds };
  tracks: Record<string, TrackHistory>;
  events: EventNews[];
  joints: Record<string, JointFacts[]>;
  /** `ROBOT/CAMERA`. */
  cameras: string[];
  /** All that a picture or a film can show. */
  views?: string[];
}

export interface Figures {
  run: Record<string, unknown>;
  robots: Record<string, Record<string, unknown>>;
}

export interface Job {
  done: number;
  total: number;
  path: string | null;
  error: string | null;
}

function query(address: string, values: Record<string, string | number>): string {
  const pairs = Object.entries(values).map(([key, value]): [string, string] => [key, String(value)]);
  return `${address}?${new URLSearchParams(pairs)}`;
}

export const recordings = {
  cards: () => getJson<RecordingCard[]>("/api/recordings"),
  plan: (path: string, theme: string) => query("/api/recording/plan", { path, theme }),
  open: (path: string) => getJson<Recording>(query("/api/recording", { path })),
  tick: (path: string, time: number) => getJson<TickNews>(query("/api/recording/tick", { path, time })),
  fields: (path: string) => getJson<Awaited<ReturnType<Source["fields"]>>>(query("/api/recording/fields", { path })),
  message: (path: string, topic: string, time: number) =>
    getJson<Message | null>(query("/api/recording/message", { path, topic, time })),
  column: (path: string, [topic, field]: Field) =>
    getJson<Column>(query("/api/recording/column", { path, topic, field })),
  /** Of a part, or of all where both ends are null. */
  statistics: (path: string, from: number | null, to: number | null) =>
    getJson<Figures>(
      query("/api/recording/statistics", { path, ...(from === null || to === null ? {} : { from, to }) }),
    ),
  film: (path: string, from: number, to: number, view: string) =>
    postJson<{ job: string }>("/api/recording/video", { path, from, to, view }),
  job: (id: string) => getJson<Job>(query("/api/job", { id })),
  file: (path: string) => query("/api/file", { path }),
  scene: (path: string) => getBytes(query("/api/recording/scene", { path })),
  poses: (path: string, time: number) => getBytes(query("/api/recording/poses", { path, time })),
  picture: (path: string, time: number, view: string, outside?: Outside) => {
    const from = outside && {
      azimuth_deg: outside.azimuth_deg,
      elevation_deg: outside.elevation_deg,
      distance: outside.distance,
      x: outside.at[0],
      y: outside.at[1],
    };
    return query("/api/recording/picture", { path, time, view, ...from });
  },
};

/** A robot of which no tick has come yet. */
export const NOTHING: RobotTick = {
  truth: [0, 0, 0],
  estimate: [0, 0, 0],
  odometry: [0, 0, 0],
  covariance: [],
  landmarks: {},
  sightings: [],
  error: 0,
  heading_error: 0,
  nees: null,
  estimated: false,
  timing: {},
  command: [0, 0, 0],
};
