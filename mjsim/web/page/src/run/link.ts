/** The connection to the run: it comes back by itself when the server does. */

import { heard } from "../words/words";
import { splitFrame } from "./frames";
import type { FrameHead, News, RunRequest } from "./protocol";

/** Shortest and longest wait before the next try [ms]. */
const FIRST_WAIT = 300;
const LONGEST_WAIT = 3000;

/**
 * Whether the server can be talked to; the others while the page tries again: `closed` was announced before, and in
 * `out` there is a server that does not know this browser, such as one that was started anew.
 */
export type LinkState = "connecting" | "open" | "lost" | "closed" | "out";

export interface LinkListener {
  state(state: LinkState): void;
  news(news: News): void;
  picture(head: FrameHead, jpeg: Blob): void;
  /** Where the bodies of the scene in 3-D are. */
  bodies(head: FrameHead, places: ArrayBuffer): void;
}

/** The view that tells where bodies are. */
const BODIES = "bodies";

/** Talks to `/api/run` for as long as it is open, through as many sockets as it takes. */
export class Link {
  private socket: WebSocket | null = null;
  private wait = FIRST_WAIT;
  private timer = 0;
  private closed = false;
  private farewell = false;
  private shutOut = false;

  constructor(private readonly listener: LinkListener) {
    this.connect();
  }

  /** Send a request; false when there is nobody to take it. */
  send(request: RunRequest): boolean {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(request));
    return true;
  }

  close(): void {
    this.closed = true;
    window.clearTimeout(this.timer);
    this.socket?.close();
  }

  private connect(): void {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    const socket = new WebSocket(`${scheme}://${location.host}/api/run`);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.wait = FIRST_WAIT;
      this.farewell = this.shutOut = false;
      this.listener.state("open");
    };
    socket.onmessage = (message: MessageEvent<string | ArrayBuffer>) => this.take(message.data);
    socket.onclose = (event) => {
      this.farewell ||= event.code === 1000;
      this.lose(socket);
    };
    this.socket = socket;
  }

  private take(data: string | ArrayBuffer): void {
    if (typeof data === "string") {
      this.listener.news(heard(JSON.parse(data) as News));
      return;
    }
    const { head, body } = splitFrame(data);
    if (head.view === BODIES) this.listener.bodies(head, body);
    else this.listener.picture(head, new Blob([body], { type: "image/jpeg" }));
  }

  private lose(socket: WebSocket): void {
    if (this.closed || this.socket !== socket) return;
    if (!this.shutOut) this.listener.state(this.farewell ? "closed" : "lost");
    void this.askWhy(socket);
    this.timer = window.setTimeout(() => this.connect(), this.wait);
    this.wait = Math.min(LONGEST_WAIT, this.wait * 1.7);
  }

  /** Find out whether the server answers, but not to this browser. */
  private async askWhy(socket: WebSocket): Promise<void> {
    const response = await fetch("/api/folder").catch(() => null);
    if (this.closed || this.socket !== socket || !response) return;
    this.shutOut = response.status === 401;
    if (this.shutOut) this.listener.state("out");
  }
}
