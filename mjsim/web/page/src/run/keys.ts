/** Driving by keyboard, and by the pad on the screen. */

/** What is pressed of forward, left and turn, each -1, 0 or 1. */
export interface Push {
  forward: number;
  left: number;
  turn: number;
}

/** The order is renewed after this long while something is held [ms]. */
const RENEW = 100;

/** How a key pushes: forward, left, turn. */
const KEYS: Record<string, [number, number, number]> = {
  KeyW: [1, 0, 0],
  KeyS: [-1, 0, 0],
  KeyA: [0, 0, 1],
  KeyD: [0, 0, -1],
  KeyQ: [0, 1, 0],
  KeyE: [0, -1, 0],
  ArrowUp: [1, 0, 0],
  ArrowDown: [-1, 0, 0],
  ArrowLeft: [0, 0, 1],
  ArrowRight: [0, 0, -1],
};

/** Gathers what is held down and tells it on, again and again while it is held; null once all is let go. */
export class Wheel {
  private readonly held = new Map<string, [number, number, number]>();
  private timer = 0;
  private readonly listening = new AbortController();

  constructor(
    private readonly enabled: () => boolean,
    private readonly push: (push: Push | null) => void,
  ) {
    const signal = this.listening.signal;
    window.addEventListener("keyup", (event) => this.release(event.code), { signal });
    window.addEventListener("blur", () => this.releaseAll(), { signal });
  }

  /** Press something by name, as the pad does. */
  press(name: string, way: [number, number, number]): void {
    if (!this.enabled()) return;
    this.held.set(name, way);
    this.tell();
    if (!this.timer) this.timer = window.setInterval(() => this.tell(), RENEW);
  }

  release(name: string): void {
    if (!this.held.delete(name)) return;
    if (this.held.size) this.tell();
    else this.end();
  }

  releaseAll(): void {
    if (!this.held.size) return;
    this.held.clear();
    this.end();
  }

  close(): void {
    this.releaseAll();
    this.listening.abort();
  }

  /** Take a key that nobody was typing; true when it drives. */
  down(event: KeyboardEvent): boolean {
    const way = KEYS[event.code];
    if (!way || event.ctrlKey || event.metaKey || event.altKey || !this.enabled()) return false;
    event.preventDefault();
    if (!event.repeat) this.press(event.code, way);
    return true;
  }

  private tell(): void {
    const sum: Push = { forward: 0, left: 0, turn: 0 };
    for (const [forward, left, turn] of this.held.values()) {
      sum.forward += forward;
      sum.left += left;
      sum.turn += turn;
    }
    const most = (value: number): number => Math.max(-1, Math.min(1, value));
    this.push({ forward: most(sum.forward), left: most(sum.left), turn: most(sum.turn) });
  }

  private end(): void {
    window.clearInterval(this.timer);
    this.timer = 0;
    this.push(null);
  }
}
