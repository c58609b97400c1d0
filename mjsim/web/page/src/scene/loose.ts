/** Robots and movable things in 3-D that are dragged on the level: a ghost shows where they will stand. */

import { Group, LineBasicMaterial, LineSegments, Mesh, MeshLambertMaterial, type Object3D, type Vector3 } from "three";
import { el } from "../ui/dom";
import { Signal } from "../ui/signal";
import { color } from "../ui/theme";
import { Gesture, inFront, inkOf, type Owner } from "./gesture";
import type { LooseThing, Put } from "./grip";
import { points } from "./marks";
import { thingOf } from "./solids";
import type { Stage3d } from "./stage";

/** How much of what is behind a ghost is hidden. */
const OPACITY = 0.45;

interface Held {
  thing: LooseThing;
  /** Where it was taken, world frame [m]. */
  taken: Vector3;
  by: Vector3 | null;
}

export class Loose implements Owner {
  readonly put = new Signal<Put>();
  /** What is written beside a ghost. */
  readonly notes = el("div", { class: "scene-notes" });
  private readonly ghost = new Group();
  private things: LooseThing[] = [];
  private bodies: Object3D[] = [];
  private held: Held | null = null;
  private readonly gesture: Gesture;

  constructor(private readonly stage: Stage3d) {
    stage.over.add(this.ghost);
    this.gesture = new Gesture(stage, this);
  }

  /** What can be dragged, and all bodies of the scene. */
  show(things: LooseThing[], bodies: Object3D[]): void {
    [this.things, this.bodies] = [things, bodies];
    if (this.held && !things.some(({ name }) => name === this.held?.thing.name)) this.gesture.giveUp();
  }

  take({ clientX, clientY }: PointerEvent): boolean {
    const hit = this.things.length && this.stage.isFree ? this.stage.under(clientX, clientY) : null;
    const met = hit && typeof hit.faceIndex === "number" ? thingOf(hit.object as Mesh, hit.faceIndex) : "";
    const thing = hit && this.things.find((each) => isOf(each, met));
    if (!thing) return false;
    this.held = { thing, taken: hit.point.clone(), by: null };
    return true;
  }

  hover(): void {
    // What lies under the pointer is not worth a look at each move.
  }

  drag({ clientX, clientY }: PointerEvent): void {
    const { held, stage } = this;
    const seen = held && stage.onLevel(clientX, clientY, held.taken.z);
    if (!held || !seen) return;
    if (!held.by) this.build(held.thing);
    held.by = seen.sub(held.taken).setZ(0);
    this.ghost.position.copy(held.by);
    const [x, y] = this.placeOf(held);
    this.write(`${held.thing.name}  ${x.toFixed(2)}, ${y.toFixed(2)}`, held.taken.clone().add(held.by));
    stage.soon();
  }

  end(done: boolean): void {
    const { held } = this;
    this.held = null;
    this.clear();
    this.stage.soon();
    if (done && held?.by) this.put.emit({ name: held.thing.name, to: this.placeOf(held) });
    else if (done && held) this.stage.picked.emit(this.stage.under(...this.stage.onPage(held.taken)));
  }

  private placeOf({ thing, by }: Held): [number, number] {
    return [thing.at[0] + (by?.x ?? 0), thing.at[1] + (by?.y ?? 0)];
  }

  /** Copies of the bodies of a thing, and the way on the floor, which moves with them. */
  private build({ name, at: [x, y] }: LooseThing): void {
    this.clear();
    const material = new MeshLambertMaterial({
      color: color("--accent"),
      transparent: true,
      opacity: OPACITY,
      depthWrite: false,
    });
    const own = this.bodies.filter((body) => isOf({ name }, String(body.userData["name"])));
    for (const body of own) {
      const copy = body.clone(true);
      copy.traverse((part) => part instanceof Mesh && (part.material = material));
      this.ghost.add(copy);
    }
    const foot = new LineSegments(
      points([x - 0.1, y, 0, x + 0.1, y, 0, x, y - 0.1, 0, x, y + 0.1, 0]),
      new LineBasicMaterial(inkOf(color("--accent"))),
    );
    inFront(this.ghost, foot);
    this.stage.canvas.dataset["ghost"] = name;
  }

  private clear(): void {
    // The copies share their shapes with the bodies.
    this.ghost.traverse((part) => {
      if (part instanceof Mesh) (part.material as MeshLambertMaterial).dispose();
      if (!(part instanceof LineSegments)) return;
      (part as LineSegments).geometry.dispose();
      ((part as LineSegments).material as LineBasicMaterial).dispose();
    });
    this.ghost.clear();
    this.notes.replaceChildren();
    delete this.stage.canvas.dataset["ghost"];
  }

  private write(text: string, place: Vector3): void {
    const [x, y] = this.stage.onCanvas(place);
    const note = this.notes.firstElementChild ?? this.notes.appendChild(el("span", {}));
    note.textContent = text;
    (note as HTMLElement).style.transform = `translate(${Math.round(x)}px, ${Math.round(y)}px)`;
  }
}

/** Whether a body or a geom of a name is a part of a robot or an obstacle. */
function isOf({ name }: { name: string }, part: string): boolean {
  return (
    part.startsWith(`${name}/`) ||
    part === `obstacle/${name}` ||
    part.startsWith(`obstacle/${name}/`) ||
    part.startsWith(`obstacle/${name}:`)
  );
}
