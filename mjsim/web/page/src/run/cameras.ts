/** The pictures of a run: every camera, with depth and segmentation where wanted, and the view from outside. */

import type { Bounds } from "../api";
import { remembered, toggle } from "../ui/controls";
import { el } from "../ui/dom";
import { makeTile, type Tile } from "../ui/tile";
import { word } from "../words/words";
import { Orbit, overlook } from "./orbit";
import type { FrameHead, Outside, RobotFacts, RunRequest } from "./protocol";
import { Screen } from "./screen";

/** The server is asked for another view from outside at most this often [ms]. */
const CALM = 60;
/** Of the view from outside, as long as none has come [px]. */
const OUTSIDE_SIZE = [960, 600] as const;
const KINDS = ["depth", "segmentation"] as const;

type Kind = (typeof KINDS)[number];

/** Where the pictures of a view are shown. */
interface Place {
  screen: Screen;
  body: HTMLElement;
  tile: Tile;
}

/** Makes a tile for each picture and says to the server which ones are wanted. */
export class Cameras {
  /** Switches for the kinds of pictures. */
  readonly switches = el("div", { class: "run-group run-switches", role: "group", "aria-label": word("run.pictures") });
  private readonly screens = new Map<string, Place>();
  private readonly wanted: Record<Kind | "outside", boolean>;
  /** Switches of what cameras alone have. */
  private readonly buttons: Record<Kind, HTMLButtonElement>;
  private orbit: Orbit | null = null;
  private isFramed = false;
  /** From where the view from outside looks before it is turned. */
  private first = overlook([0, 0, 8, 8]);
  private robots: RobotFacts[] = [];
  private isThere = false;
  private timer = 0;

  constructor(
    private readonly send: (request: RunRequest) => void,
    /** Told when there are other tiles. */
    private readonly changed: () => void,
    /** Whether the view in 3-D waits for the places of bodies. */
    private readonly bodies: () => boolean,
  ) {
    this.wanted = {
      depth: remembered("run.depth") === "yes",
      segmentation: remembered("run.segmentation") === "yes",
      outside: remembered("run.outside") !== "no",
    };
    const button = (kind: Kind | "outside", label: string): HTMLButtonElement =>
      toggle({ class: "quiet run-small" }, this.wanted[kind], (on) => this.want(kind, on), label);
    this.buttons = {
      depth: button("depth", word("run.depth")),
      segmentation: button("segmentation", word("run.segments")),
    };
    this.switches.append(...Object.values(this.buttons), button("outside", word("run.outside")));
  }

  /** Tiles in the order in which they are shown. */
  tiles(): Tile[] {
    return this.keys().map((key) => this.place(key).tile);
  }

  /** Take up the robots of a run, and whether there is one. */
  run(robots: RobotFacts[], isThere: boolean): void {
    const before = this.keys().join();
    this.robots = robots;
    this.isThere = isThere;
    const blind = !robots.some((robot) => robot.cameras.length);
    for (const kind of KINDS) this.buttons[kind].hidden = blind;
    if (this.keys().join() === before) return;
    this.changed();
    this.watch();
  }

  scene(bounds: Bounds): void {
    this.first = overlook(bounds);
    this.isFramed = true;
    if (this.orbit) this.orbit.view = this.first;
    this.watch();
  }

  clear(): void {
    for (const { screen } of this.screens.values()) screen.clear();
  }

  show(head: FrameHead, jpeg: Blob): void {
    const found = this.screens.get(head.view);
    if (found) found.screen.show(head, jpeg);
    else this.send({ do: "shown", number: head.number });
  }

  /** Say what is to be sent; called too when the connection has come back. */
  watch(): void {
    const cameras = this.robots.flatMap((robot) => robot.cameras.map((camera) => `${robot.name}/${camera.name}`));
    const { depth, segmentation, outside } = this.wanted;
    // Before it is known how large the world is, a picture would show some other place.
    const view: Outside | null = outside && this.orbit && this.isFramed ? this.orbit.view : null;
    this.send({ do: "watch", cameras, depth, segmentation, outside: view, bodies: this.bodies() });
  }

  /** Pictures shown a second, of the view that shows most. */
  rate(): number {
    return Math.max(0, ...[...this.screens.values()].map(({ screen }) => screen.rate.value()));
  }

  private want(kind: Kind | "outside", on: boolean): void {
    this.wanted[kind] = on;
    remembered(`run.${kind}`, on ? "yes" : "no");
    this.changed();
    this.watch();
  }

  private keys(): string[] {
    const cameras = this.robots.flatMap((robot) =>
      robot.cameras.flatMap((camera) => {
        const key = `${robot.name}/${camera.name}`;
        return [key, ...KINDS.filter((kind) => this.wanted[kind]).map((kind) => `${key}:${kind}`)];
      }),
    );
    return this.wanted.outside && this.isThere ? [...cameras, "outside"] : cameras;
  }

  private place(key: string): Place {
    const size = this.sizeOf(key);
    const ratio = `${size[0]} / ${size[1]}`;
    const found = this.screens.get(key);
    if (found) {
      // Another world may have a camera of this name with another shape.
      found.body.style.aspectRatio = ratio;
      return found;
    }
    const title = titleOf(key);
    const screen = new Screen(title, (head) => this.send({ do: "shown", number: head.number }));
    screen.shape(...size);
    const waiting = el("p", { class: "hint run-waiting" }, word("run.noPictureYet"));
    const body = el("div", { class: "run-picture" }, screen.canvas, waiting);
    body.style.aspectRatio = ratio;
    const made = { screen, body, tile: makeTile(key, title, body) };
    this.screens.set(key, made);
    if (key === "outside") this.makeOrbit(screen);
    return made;
  }

  /** Width and height of the pictures of a view [px]. */
  private sizeOf(key: string): readonly [number, number] {
    const [name] = key.split(":");
    const cameras = this.robots.flatMap((robot) =>
      robot.cameras.filter((each) => name === `${robot.name}/${each.name}`),
    );
    const [camera] = cameras;
    return camera ? [camera.width, camera.height] : OUTSIDE_SIZE;
  }

  private makeOrbit(screen: Screen): void {
    screen.canvas.setAttribute("aria-label", word("run.viewFromOutsideDragWheel"));
    screen.canvas.classList.add("run-orbit");
    this.orbit = new Orbit(screen.canvas, this.first, () => this.soon());
  }

  private soon(): void {
    if (this.timer) return;
    this.timer = window.setTimeout(() => {
      this.timer = 0;
      this.watch();
    }, CALM);
  }
}

function titleOf(key: string): string {
  if (key === "outside") return word("run.outside");
  const [camera, kind] = key.split(":");
  return `${(camera ?? key).replace("/", " · ")}${kind ? `, ${kind}` : ""}`;
}
