/** This tab's connection to the server: it says what the tab shows, and hears what changes on disk and in other tabs. */

import type { Draft } from "../api";
import { Signal } from "../ui/signal";

/** Shortest and longest wait before the next try [ms]. */
const FIRST_WAIT = 300;
const LONGEST_WAIT = 3000;

/** What a tab shows: its world, the stamp of the content that it knows on disk, and the files as they were read. */
export interface Shown {
  path: string;
  stamp: string | null;
  files: Record<string, string>;
}

type News =
  | { kind: "disk"; path: string; stamp: string | null }
  | { kind: "files"; files: string[] }
  | { kind: "drafts"; drafts: Draft[] };

export class TabLink {
  /** Another one each time the page is loaded: a tab that is duplicated or reloaded is a tab of its own. */
  readonly id = [...crypto.getRandomValues(new Uint8Array(8))]
    .map((byte) => byte.toString(16).padStart(2, "0"))
    .join("");
  /** The file of the world has other content, of this stamp; null: it is gone. */
  readonly disk = new Signal<{ path: string; stamp: string | null }>();
  /** Files that the world names have changed. */
  readonly files = new Signal<string[]>();
  /** The drafts of other tabs, those that are open and those that were left. */
  readonly drafts = new Signal<Draft[]>();
  /** The server answers again, or no longer. */
  readonly stateChanged = new Signal();
  isOpen = false;
  private socket: WebSocket | null = null;
  private wait = FIRST_WAIT;
  private shown = "";

  constructor() {
    this.connect();
  }

  /** Say what the tab shows, if it is something else than before. */
  show(shown: Shown): void {
    const text = JSON.stringify({ do: "show", ...shown });
    if (text === this.shown) return;
    this.shown = text;
    if (this.isOpen) this.socket?.send(text);
  }

  private connect(): void {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    const socket = new WebSocket(`${scheme}://${location.host}/api/tab?tab=${this.id}`);
    socket.onopen = () => {
      this.wait = FIRST_WAIT;
      if (this.shown) socket.send(this.shown);
      this.turn(true);
    };
    socket.onmessage = (message: MessageEvent<string>) => this.take(JSON.parse(message.data) as News);
    socket.onclose = () => {
      this.turn(false);
      window.setTimeout(() => this.connect(), this.wait);
      this.wait = Math.min(LONGEST_WAIT, this.wait * 1.7);
    };
    this.socket = socket;
  }

  private turn(isOpen: boolean): void {
    if (this.isOpen === isOpen) return;
    this.isOpen = isOpen;
    this.stateChanged.emit();
  }

  private take(news: News): void {
    if (news.kind === "disk") this.disk.emit(news);
    else if (news.kind === "files") this.files.emit(news.files);
    else this.drafts.emit(news.drafts);
  }
}
