/** Pictures of the time that is looked at: each view fetches the newest one it has time for. */

import { el } from "../dom";
import type { Bounds } from "../api";
import { newestWins } from "../signal";
import { Orbit, overlook } from "../run/orbit";
import type { Outside } from "../run/protocol";
import { makeTile, type Tile } from "../run/tile";
import { titleOf } from "./film";
import { recordings, type Recording } from "./recording";

interface Shown {
  tile: Tile;
  ask(time: number): void;
  again(): void;
}

export class Pictures {
  private readonly views = new Map<string, Shown>();
  private recording: Recording | null = null;
  private outside: Outside = overlook([0, 0, 8, 8]);
  private turned = false;
  private time = 0;

  load(recording: Recording): void {
    this.recording = recording;
    this.turned = false;
    this.views.clear();
    this.outside = overlook(recording.scene.bounds);
    for (const view of [...recording.cameras, "outside", "chase"]) this.views.set(view, this.make(view, recording.scene.bounds));
  }

  tiles(): Tile[] {
    return [...this.views.values()].map(({ tile }) => tile);
  }

  show(time: number): void {
    this.time = time;
    for (const view of this.views.values()) view.ask(time);
  }

  private make(view: string, bounds: Bounds): Shown {
    const canvas = el("canvas", { class: "run-screen", role: "img", "aria-label": titleOf(view), width: 640, height: 480 });
    const note = el("p", { class: "hint run-waiting" }, "No picture yet");
    const body = el("div", { class: "run-picture", style: "aspect-ratio: 4 / 3" }, canvas, note);
    const ask = newestWins((time: number) => this.fetch(view, time, canvas, note));
    if (view === "outside") this.orbit(canvas, bounds, () => ask(this.time));
    return { tile: makeTile(view, titleOf(view), body), ask, again: () => ask(this.time) };
  }

  private orbit(canvas: HTMLCanvasElement, bounds: Bounds, again: () => void): void {
    canvas.classList.add("run-orbit");
    canvas.setAttribute("aria-label", "View from outside; drag, wheel, arrows and + - turn it");
    new Orbit(canvas, overlook(bounds), (view) => {
      this.outside = view;
      this.turned = true;
      again();
    });
  }

  private async fetch(view: string, time: number, canvas: HTMLCanvasElement, note: HTMLElement): Promise<void> {
    const recording = this.recording;
    // A view that is not on the page costs nothing.
    if (!recording || !canvas.isConnected) return;
    const outside = view === "outside" && this.turned ? this.outside : undefined;
    const response = await fetch(recordings.picture(recording.path, time, view, outside)).catch(() => null);
    if (!response?.ok || this.recording !== recording) {
      if (response && !response.ok) note.textContent = ((await response.json().catch(() => ({}))) as { error?: string }).error ?? "No picture";
      return;
    }
    const bitmap = await createImageBitmap(await response.blob()).catch(() => null);
    if (!bitmap) return;
    if (canvas.width !== bitmap.width || canvas.height !== bitmap.height) {
      Object.assign(canvas, { width: bitmap.width, height: bitmap.height });
      canvas.parentElement?.style.setProperty("aspect-ratio", `${bitmap.width} / ${bitmap.height}`);
    }
    canvas.getContext("2d")?.drawImage(bitmap, 0, 0);
    bitmap.close();
    canvas.dataset["time"] = String(time);
    canvas.toggleAttribute("data-filled", true);
  }
}
