/** What the server offers: its values, and one call for each of its addresses. */

import { ApiError } from "./failures";
import type { Item } from "./run/protocol";
import { heard, said, word } from "./words/words";

export type Point = [number, number];
export type Path = (string | number)[];
export type Values = Record<string, unknown>;
export type Bounds = [number, number, number, number];

export type { Item };
export { ApiError };

export interface Problem {
  line: number;
  column: number;
  message: string;
  path: Path | null;
  kind: "error" | "warning";
}

export interface WorldValues {
  values: Values;
  written: string[];
  raw?: Values;
}

/** Code that waits to be allowed: files with the SHA-256 of their content, installed classes with an empty text. */
export type Code = Record<string, string>;

export interface Parsed {
  problems: Problem[];
  /** null: the text cannot be read; keep the last ones. */
  items: Item[] | null;
  bounds: Bounds;
  name: string;
  run: Values;
  needs_trust: Code;
  world?: WorldValues;
  /** That the text names, there or not, by their paths from its folder; and what tells their states apart. */
  files: Record<string, string>;
}

export interface Opened extends Parsed {
  path: string;
  text: string;
  stamp: string | null;
}

export interface Edited extends Parsed {
  text: string;
}

/** What the server is to keep; `restored`: the draft of a closed tab that it goes on from, which goes in the same moment. */
export interface DraftKept {
  path: string;
  fresh: boolean;
  stamp: string | null;
  text: string;
  past: Past;
  restored?: string;
}

/** Unsaved changes that the server keeps. */
export interface Draft {
  id: string;
  tab: string;
  path: string;
  /** Never saved: the path is only what it was to be called. */
  fresh: boolean;
  /** When it was kept [s since 1970]. */
  when: number;
  /** Whether a tab has it open. */
  open: boolean;
}

export interface DraftText extends Draft {
  text: string;
  /** Of the content that the text was made from. */
  stamp: string | null;
  /** Whether the world that it was made from is there. */
  there: boolean;
  past: Past;
}

/** The steps around a text, so that it can be undone: at `from` stood `old`, then `fresh`; `what` that did. `at` of them lead to it. */
export interface Past {
  steps: { from: number; old: string; fresh: string; what?: string }[];
  at: number;
}

/** Orders of a tab are numbered: one that arrives late does not undo a newer one. */
export interface DraftOrder {
  tab: string;
  number: number;
}

export interface Folder {
  folder: string;
  worlds: string[];
  recordings: string[];
  /** Folders of what `mjsim sweep` left. */
  sweeps: string[];
  pictures: string[];
  /** Files of MJCF and URDF. */
  models: string[];
  /** Presets of robots, and files that become one. */
  robots: string[];
  /** Descriptions of worlds by their paths; '' for none. */
  abouts: Record<string, string>;
  world: string | null;
  mode: "studio" | "live";
  shipped: {
    worlds: string[];
    pictures: string[];
    models: string[];
    arms: string[];
    /** Presets by the kind of sensor. */
    sensors: Record<string, string[]>;
    presets: { name: string; about: string }[];
    templates: string[];
    /** A sentence about each template. */
    about: Record<string, string>;
  };
}

export type Change =
  | { op: "set"; path: Path; value: unknown }
  | { op: "unset"; path: Path }
  | { op: "rename"; path: Path; value: string }
  | { op: "add"; path: Path; value: unknown }
  | { op: "remove"; path: Path }
  | { op: "single" | "apart"; path: Path };

export interface Module {
  use: string;
  title: string;
  about: string;
  /** Readings of which it needs one; none: it fits every robot. */
  needs: string[];
  /** What its robot must have besides: arms, balancing, max_left (a drive that can go sideways). */
  parts: ("arms" | "balancing" | "max_left")[];
  /** JSON Schema of the keys beside `use`. */
  options: Values;
}

/** What recognition makes of a picture: up to where it is found [m], and what is wrong with it. */
export interface Verdict {
  distance: number;
  fault: string | null;
}

/** What there is for each role, the most useful first. */
export interface Modules {
  observers: Module[];
  estimators: Module[];
  navigators: Module[];
  avoidances: Module[];
  controllers: Module[];
  /** Reading of each kind of sensor. */
  sensors: Record<string, string>;
  /** Why a file of the folder cannot be imported, by its name. */
  faults: Record<string, string>;
  /** `use:` of the programs of the folder. */
  programs: string[];
}

/** What is done to a mechanism or a person; nothing: it is shown as it is. */
export interface PoseWish {
  /** Of joints [deg, m]. */
  values?: Record<string, number>;
  /** Where hands are led, in the world [m]. */
  hands?: Record<string, [number, number, number]>;
  pull?: { look: "above" | Look; part: string; start: Point; end: Point };
}

/** From where a drawing beside the plan shows it. */
export type Look = "side" | "front";

export interface PoseAsk extends PoseWish {
  path: string;
  text: string;
  item: ["mechanisms" | "people", number];
  look: Look;
}

/** A value of a joint [deg, m]. */
export interface JointValue {
  name: string;
  value: number;
  low: number;
  high: number;
  unit: string;
  /** Whether it can start elsewhere. */
  free: boolean;
}

/** A mechanism or a person as it is, or would be. */
export interface Pose {
  look: Look;
  /** What of the plan it consists of, and where that is. */
  items: Pick<Item, "path" | "polygons" | "at" | "heading_deg">[];
  /** Its outlines from aside [m], with what is pulled by them. */
  parts: { name: string; outline: Point[]; pull: string | null }[];
  values: JointValue[];
  hands: Record<string, [number, number, number]>;
  changes: Change[];
  note: string;
}

export interface PreviewAsk {
  path: string;
  text: string;
  robot: string;
  camera: string;
  at: Point;
  heading_deg: number;
  width: number;
}

const GONE = word("start.gone");

/** Ask the server for JSON. Raises ApiError. */
export async function getJson<T>(address: string): Promise<T> {
  return heard((await (await answer(address, {})).json()) as T);
}

/** Send JSON to the server and get JSON back. Raises ApiError. */
export async function postJson<T>(address: string, body: unknown): Promise<T> {
  return heard((await (await post(address, body)).json()) as T);
}

/** Ask the server for bytes. Raises ApiError. */
export async function getBytes(address: string): Promise<ArrayBuffer> {
  return (await answer(address, {})).arrayBuffer();
}

/** Send JSON and get back the bytes of a picture. Raises ApiError. */
export async function postForBlob(address: string, body: unknown): Promise<Blob> {
  return (await post(address, body)).blob();
}

/** The text of a module, and the line where its class begins, counted from 1. */
export interface SourceText {
  name: string;
  text: string;
  line: number;
}

/** The calls of editing. */
export const api = {
  folder: () => getJson<Folder>("/api/folder"),
  judge: (path: string, text: string, images: string[]) =>
    postJson<{ pictures: Record<string, Verdict> }>("/api/judge", { path, text, images }),
  schema: () => getJson<Values>("/api/schema"),
  /** Those that come with mjsim, and those beside a world, or in the folder. */
  modules: (world: string | null = null) =>
    getJson<Modules>(`/api/modules${world === null ? "" : `?${new URLSearchParams({ path: world })}`}`),
  open: (path: string) => postJson<Opened>("/api/open", { path }),
  create: (template?: string) => postJson<Opened>("/api/new", template ? { template } : {}),
  parse: (path: string, text: string) => postJson<Parsed>("/api/parse", { path, text }),
  edit: (path: string, text: string, changes: Change[]) => postJson<Edited>("/api/edit", { path, text, changes }),
  items: (text: string) => postJson<{ items: { list: string; value: Values }[] }>("/api/items", { text }),
  source: (path: string, text: string, use: string) => postJson<SourceText>("/api/source", { path, text, use }),
  save: (path: string, text: string, stamp: string | null, overwrite = false) =>
    postJson<{ stamp: string }>("/api/save", { path, text, stamp, ...(overwrite ? { overwrite } : {}) }),
  drafts: () => getJson<{ drafts: Draft[] }>("/api/drafts"),
  keepDraft: (order: DraftOrder & DraftKept) => postJson<Values>("/api/draft/keep", order),
  forgetDraft: (order: DraftOrder) => postJson<Values>("/api/draft/forget", order),
  readDraft: (id: string) => postJson<DraftText>("/api/draft/read", { id }),
  dropDraft: (id: string) => postJson<Values>("/api/draft/drop", { id }),
  trust: (path: string, text: string, code: Code) => postJson<Values>("/api/trust", { path, text, code }),
  pose: async (ask: PoseAsk): Promise<Pose> => {
    const pose = await postJson<Omit<Pose, "look">>("/api/pose", ask);
    return { ...pose, note: said(pose.note), look: ask.look };
  },
  scene: async (path: string, text: string) => (await postForBlob("/api/scene", { path, text })).arrayBuffer(),
  preview: (ask: PreviewAsk) => postForBlob("/api/preview", ask),
  /** How often pictures have changed on disk; browsers keep those of an address. */
  version: 0,
  /** Address of a thumbnail; `world` is the path of the world file that names it. */
  picture(path: string, size: number, world?: string | null): string {
    const asked = new URLSearchParams({ path, size: String(size), ...(world ? { world } : {}) });
    if (this.version) asked.set("version", String(this.version));
    return `/api/picture?${asked}`;
  },
  /** Address of a picture of a thing by itself, as a world of this path names it. */
  portrait(kind: "model" | "robot" | "arm", name: string, world: string | null): string {
    const asked = new URLSearchParams({ kind, name, ...(world ? { world } : {}) });
    if (this.version) asked.set("version", String(this.version));
    return `/api/portrait?${asked}`;
  },
  /** Make a preset of a robot's file beside a world. */
  robot: (file: string, path: string | null) =>
    postJson<{ path: string; report: string[] }>("/api/robot", { file, path }),
  /** Put a picture beside a world; `path` is what the world then calls it. */
  upload: async (file: File, world: string | null) => {
    const address = `/api/upload?${new URLSearchParams({ name: file.name, ...(world ? { path: world } : {}) })}`;
    return (await (await answer(address, { method: "POST", body: file })).json()) as { path: string };
  },
};

export type Api = typeof api;

function post(address: string, body: unknown): Promise<Response> {
  return answer(address, {
    method: "POST",
    headers: { "content-type": "application/json" },
    body: JSON.stringify(body),
  });
}

async function answer(address: string, request: RequestInit): Promise<Response> {
  let response: Response;
  try {
    response = await fetch(address, request);
    // The body is read here: a server that is killed cuts it.
    response = new Response(await response.arrayBuffer(), response);
  } catch {
    throw new ApiError(0, GONE);
  }
  if (response.ok) return response;
  const data = heard((await response.json().catch(() => ({}))) as Values);
  const message =
    typeof data["error"] === "string" ? said(data["error"]) : word("start.answered", { status: response.status });
  throw new ApiError(response.status, message, data);
}
