/** Pictures of the time that is looked at: each view fetches the newest one it has time for. */

import { Orbit, overlook } from "../run/orbit";
import type { Outside } from "../run/protocol";
import { drawRecognised, pixelRatio } from "../run/screen";
import { remembered, toggle } from "../ui/controls";
import { el } from "../ui/dom";
import { newestWins } from "../ui/signal";
import { makeTile, type Tile } from "../ui/tile";
import { heard, said, word } from "../words/words";
import { titleOf } from "./film";
import type { Looked } from "./looked";
import { type Recording, recordings } from "./recording";

interface Shown {
  tile: Tile;
  canvas: HTMLCanvasElement;
  ask(time: number): void;
  /** The picture without what is drawn on it, and its time [s]. */
  plain: { bitmap: ImageBitmap; time: number } | null;
}

/** What may be switched on beside the cameras. */
const KINDS = [
  ["depth", word("review.depth")],
  ["segmentation", word("review.segments")],
  ["outside", word("review.outside")],
  ["chase", word("review.behind")],
] as const;

type Kind = (typeof KINDS)[number][0];

export class Pictures {
  /** Switches for the kinds of pictures. */
  readonly switches = el("div", { class: "run-switches", role: "group", "aria-label": word("review.pictures") });
  private readonly views = new Map<string, Shown>();
  private readonly wanted = new Set<Kind>((remembered("review.views") ?? "outside").split(" ") as Kind[]);
  private outside: Outside = overlook([0, 0, 8, 8]);
  private turned = false;

  constructor(
    private readonly looked: Looked,
    /** Told when there are other tiles. */
    private readonly changed: () => void,
  ) {
    for (const [kind, label] of KINDS) {
      const attributes = { class: "quiet run-small", "data-kind": kind };
      this.switches.append(toggle(attributes, this.wanted.has(kind), (on) => this.want(kind, on), label));
    }
  }

  load(recording: Recording): void {
    this.turned = false;
    for (const { plain } of this.views.values()) plain?.bitmap.close();
    this.views.clear();
    this.outside = overlook(recording.scene.bounds);
    // Only cameras have these, and robots are followed from behind.
    const { cameras, robots } = recording;
    const needs = { depth: cameras, segmentation: cameras, outside: [true], chase: robots };
    for (const [kind] of KINDS)
      this.switches.querySelector(`[data-kind=${kind}]`)?.toggleAttribute("hidden", needs[kind].length === 0);
  }

  tiles(): Tile[] {
    return this.keys().map((view) => this.place(view).tile);
  }

  show(): void {
    for (const view of this.keys()) this.place(view).ask(this.looked.time);
  }

  /** Outline what was recognised at a tick in the pictures of that time. */
  recognise(): void {
    for (const [view, shown] of this.views) this.paint(view, shown);
  }

  private want(kind: Kind, on: boolean): void {
    if (on) this.wanted.add(kind);
    else this.wanted.delete(kind);
    remembered("review.views", [...this.wanted].join(" "));
    this.changed();
    this.show();
  }

  private keys(): string[] {
    const has = (kind: Kind): boolean => this.wanted.has(kind);
    const kinds = (["depth", "segmentation"] as const).filter(has);
    const { recording } = this.looked;
    const cameras = (recording?.cameras ?? []).flatMap((camera) => [
      camera,
      ...kinds.map((kind) => `${camera}:${kind}`),
    ]);
    const chase = recording?.robots.length ? (["outside", "chase"] as const) : (["outside"] as const);
    return [...cameras, ...chase.filter(has)];
  }

  private place(view: string): Shown {
    const found = this.views.get(view);
    if (found) return found;
    const title = titleOf(view);
    const canvas = el("canvas", { class: "run-screen", role: "img", "aria-label": title, width: 640, height: 480 });
    const note = el("p", { class: "hint run-waiting" }, word("review.noPictureYet"));
    const body = el("div", { class: "run-picture", style: "aspect-ratio: 4 / 3" }, canvas, note);
    const ask = newestWins((time: number) => this.fetch(view, time, note));
    if (view === "outside") this.orbit(canvas, () => ask(this.looked.time));
    const made: Shown = { tile: makeTile(view, title, body), canvas, ask, plain: null };
    this.views.set(view, made);
    return made;
  }

  private orbit(canvas: HTMLCanvasElement, again: () => void): void {
    canvas.classList.add("run-orbit");
    canvas.setAttribute("aria-label", word("review.viewFromOutsideDragWheel"));
    new Orbit(canvas, this.outside, (view) => {
      this.outside = view;
      this.turned = true;
      again();
    });
  }

  private async fetch(view: string, time: number, note: HTMLElement): Promise<void> {
    const { recording } = this.looked;
    const shown = this.views.get(view);
    // A view that is not on the page costs nothing.
    if (!recording || !shown?.canvas.isConnected) return;
    const outside = view === "outside" && this.turned ? this.outside : undefined;
    const response = await fetch(recordings.picture(recording.path, time, view, outside)).catch(() => null);
    if (!response || this.looked.recording !== recording) return;
    if (!response.ok) {
      const answer = heard((await response.json().catch(() => ({}))) as { error?: string });
      note.textContent = answer.error ? said(answer.error) : word("review.noPicture");
      return;
    }
    const bitmap = await createImageBitmap(await response.blob()).catch(() => null);
    if (!bitmap) return;
    if (this.looked.recording !== recording) return bitmap.close();
    shown.plain?.bitmap.close();
    shown.plain = { bitmap, time };
    this.paint(view, shown);
  }

  private paint(view: string, { canvas, plain }: Shown): void {
    const context = canvas.getContext("2d");
    if (!plain || !context) return;
    const { width, height } = plain.bitmap;
    if (canvas.width !== width || canvas.height !== height) {
      Object.assign(canvas, { width, height });
      canvas.parentElement?.style.setProperty("aspect-ratio", `${width} / ${height}`);
    }
    context.drawImage(plain.bitmap, 0, 0);
    const { tick, recording } = this.looked;
    const close = tick && Math.abs(tick.time - plain.time) < 0.5 * (recording?.dt ?? 0);
    const [robot, camera] = view.split("/");
    const looks = close && camera && !camera.includes(":") && this.isFirstCamera(view);
    if (looks) drawRecognised(context, tick?.robots[robot ?? ""]?.recognised ?? [], pixelRatio(canvas));
    canvas.dataset["time"] = String(plain.time);
    canvas.toggleAttribute("data-filled", true);
  }

  /** Sightings do not say in which picture they are: observers look at one camera, most often the first. */
  private isFirstCamera(view: string): boolean {
    const robot = view.slice(0, view.indexOf("/") + 1);
    return this.looked.recording?.cameras.find((camera) => camera.startsWith(robot)) === view;
  }
}
