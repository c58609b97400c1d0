/** The time that is looked at, and how it goes on by itself. */

import { Signal } from "../ui/signal";

export class Player {
  readonly changed = new Signal<number>();
  readonly playingChanged = new Signal<boolean>();
  speed = 1;
  private now = 0;
  /** Where it ends [s]; `load` says. */
  end = 0;
  private dt = 0.04;
  private frame = 0;
  private last = 0;

  get time(): number {
    return this.now;
  }

  get playing(): boolean {
    return this.frame !== 0;
  }

  /** Take up a recording of so many seconds and so long a tick [s], at a time of it. */
  load(seconds: number, dt: number, time = 0): void {
    this.pause();
    this.end = seconds;
    this.dt = dt;
    this.seek(time);
  }

  seek(time: number): void {
    this.now = Math.min(Math.max(time, 0), this.end);
    this.changed.emit(this.now);
  }

  /** Go so many ticks ahead, or back, from tick to tick. */
  step(ticks: number): void {
    this.pause();
    this.seek((Math.round(this.now / this.dt) + ticks) * this.dt);
  }

  play(): void {
    if (this.frame || this.end === 0) return;
    if (this.now >= this.end - this.dt / 2) this.seek(0);
    this.last = performance.now();
    this.frame = requestAnimationFrame((now) => this.go(now));
    this.playingChanged.emit(true);
  }

  pause(): void {
    if (!this.frame) return;
    cancelAnimationFrame(this.frame);
    this.frame = 0;
    this.playingChanged.emit(false);
  }

  toggle(): void {
    if (this.playing) this.pause();
    else this.play();
  }

  private go(now: number): void {
    const elapsed = Math.max(0, now - this.last) / 1000;
    this.last = now;
    this.seek(this.now + elapsed * this.speed);
    if (this.now >= this.end) return this.pause();
    this.frame = requestAnimationFrame((next) => this.go(next));
  }
}
