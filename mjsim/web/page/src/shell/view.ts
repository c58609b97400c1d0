/** What the three views have in common, and what the shell gives to each of them. */

import type { Api, Folder } from "../api";
import type { WorldDocument } from "./document";
import type { Toasts } from "./toasts";
import type { RunCode } from "./trust";

export type ViewName = "edit" | "run" | "review";

/** One of the tabs. It is made once, when it is first shown. */
export interface View {
  readonly element: HTMLElement;
  /** It has come on the screen: measure, begin to draw. */
  shown(): void;
  /** Another has taken its place: stop drawing. */
  hidden(): void;
  /** A key that nobody was typing; true when it was for this view. */
  key?(event: KeyboardEvent): boolean;
}

/** A time of a recording [s]. */
export interface Moment {
  path: string;
  time: number;
}

export interface Studio {
  readonly api: Api;
  /** What the folder held when the studio was opened or last asked. */
  folder: Folder;
  /** The world that is open: its path and text, saved or not. */
  readonly document: WorldDocument;
  readonly toasts: Toasts;
  /** How often a tab has been shown or chosen again: who has gone somewhere meanwhile is not taken elsewhere. */
  readonly visits: number;
  /** The tab that is shown; null before the first. */
  readonly view: ViewName | null;
  /** Show a tab; Review may be told which recording to open, and at which time [s]. */
  show(view: ViewName, recording?: string, time?: number): void;
  /** The recording that Review is to open when it is next shown, and the time to look at. */
  recording: Moment | null;
  /** What Review shows now; null for no recording. The address says it. */
  looksAt(moment: Moment | null): void;
  /** Let the person choose a world to open, or what a new one begins with. */
  askOpen(): Promise<void>;
  askNew(): Promise<void>;
  /** Wait for a world that is being opened, and until the text of the one that is open is settled. */
  settled(): Promise<void>;
  /** Ask for the folder's files again. */
  refresh(): Promise<void>;
  /** Let the person allow the world's own code, or that of a run; false: they would rather not. */
  askTrust(run?: RunCode): Promise<boolean>;
}
