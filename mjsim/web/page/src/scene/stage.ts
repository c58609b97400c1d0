/** A canvas with a scene: looked at from where one likes, drawn only when something has changed, as sharp as time allows. */

import {
  AmbientLight,
  Box3,
  type Camera,
  Color,
  DirectionalLight,
  Group,
  type Intersection,
  Mesh,
  MeshBasicMaterial,
  type Object3D,
  PerspectiveCamera,
  Plane,
  Raycaster,
  Scene,
  Sphere,
  Vector2,
  Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import type { Point } from "../api";
import { el } from "../ui/dom";
import { Signal } from "../ui/signal";
import { color } from "../ui/theme";
import { whenDrawn } from "./fence";
import { distanceToSee } from "./frame";
import { drawnBy, isSlow } from "./graphics";
import { Pace } from "./pace";
import { Shade } from "./shade";
import { Sky } from "./sky";

/** A picture is to take between so long [ms]; beyond, the next ones have fewer or more pixels. */
const LONGEST = 40;
const SHORTEST = 20;
/** Least share of the pixels along a side. */
const COARSEST = 0.35;
/** All pixels are drawn once nothing has changed for so long [ms]. */
const CALM = 250;
const FIELD = 50;
const FROM = new Vector3(-0.55, -0.75, 0.7);
/** From where a robot that is followed is seen over the walls. */
export const ABOVE = new Vector3(-0.3, -0.4, 1);
/** A press that moves less than this picks [px]. */
const STILL = 5;

export class Stage3d {
  readonly canvas = el("canvas", { class: "scene-canvas", tabindex: 0, role: "img" });
  readonly scene = new Scene();
  /** Things that are drawn over the scene, and are no part of it. */
  readonly over = new Group();
  readonly orbit = new PerspectiveCamera(FIELD, 1, 0.02, 500);
  readonly controls: OrbitControls;
  /** A press without a move: what it met first, if anything. */
  readonly picked = new Signal<Intersection | null>();
  /** Emitted when the view returns to the free camera. */
  readonly freed = new Signal();
  /** Told with the camera before each picture. */
  readonly drawing = new Signal<Camera>();
  /** Whether pictures come quickly enough. */
  readonly pacing = new Pace();
  /** How many things the scene has. */
  things = 0;
  private readonly renderer: WebGLRenderer;
  /** Whether pictures are drawn by the processor: then they are shaded when nothing moves. */
  private readonly isSlow: boolean;
  private readonly content = new Group();
  private boxOfThings = (): Box3 => new Box3();
  private eye: Camera = this.orbit;
  private readonly sky: Sky;
  private readonly shade: Shade;
  /** Whether the picture that is seen is shaded. */
  private isShaded = false;
  private share = 1;
  private asked = 0;
  /** Whether a picture is being drawn, and whether another one was asked for meanwhile. */
  private busy = false;
  private again = false;
  /** Whether a picture with all pixels and all light is being drawn. */
  private polishes = false;
  private calm = 0;
  /** The share that the canvas has the pixels for: all of them once it is calm, though there is no time for it. */
  private has = 0;
  private pressed: Point | null = null;
  private drawn = 0;
  /** Bounding sphere of the scene. */
  private readonly ball = new Sphere();
  /** From where all of it is seen, the middle that is looked at then, and the direction; null when it was never fitted. */
  private fitted: [Vector3, Vector3, Vector3] | null = null;

  /** `label` names the picture; `refusal` is the message of the Error where the browser draws nothing in 3-D. */
  constructor(label: string, refusal: string) {
    this.canvas.setAttribute("aria-label", label);
    this.isSlow = isSlow(drawnBy(refusal));
    this.renderer = new WebGLRenderer({ canvas: this.canvas, antialias: !this.isSlow });
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.autoUpdate = false;
    this.shade = new Shade(this.isSlow ? 0 : 4);
    this.sky = new Sky(this.isSlow ? 1024 : 2048);
    this.orbit.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.orbit, this.canvas);
    this.controls.maxPolarAngle = 0.98 * Math.PI;
    this.controls.zoomToCursor = true;
    this.controls.listenToKeyEvents(this.canvas);
    this.controls.addEventListener("change", () => this.soon());
    const lamp = new DirectionalLight("white", 1.6);
    lamp.position.set(-0.4, 0.6, 1);
    this.orbit.add(lamp);
    this.scene.add(this.content, this.over, this.orbit, this.sky, this.sky.target, new AmbientLight("white", 1.2));
    this.recolor();
    this.listen();
  }

  /** Show this in the place of what was shown; `things` gives the box that is looked at when all is to be seen. */
  show(root: Object3D, things: () => Box3): void {
    this.boxOfThings = things;
    this.content.clear();
    this.content.add(root);
    new Box3().setFromObject(root).getBoundingSphere(this.ball);
    this.shade.isBaked = false;
    root.traverse((part) => this.cast(part));
    this.sky.over(this.boxOfThings());
    this.moved();
  }

  /** Bodies are elsewhere, and so are their shadows. */
  moved(): void {
    this.renderer.shadowMap.needsUpdate = true;
    this.soon();
  }

  /** Draw edges, or not. */
  setEdges(on: boolean): void {
    this.shade.edges = on;
    this.soon();
  }

  private cast(part: Object3D): void {
    if (!(part instanceof Mesh)) return;
    part.castShadow = part.receiveShadow = true;
    this.shade.isBaked ||= part.material instanceof MeshBasicMaterial;
  }

  /** Look at all of it, from a corner unless told. */
  fit(from = FROM): void {
    const box = this.boxOfThings();
    if (box.isEmpty()) box.set(new Vector3(-5, -5, 0), new Vector3(5, 5, 1));
    const up = Math.tan((0.5 * FIELD * Math.PI) / 180);
    const { x, y, z } = box.getSize(new Vector3());
    const distance = distanceToSee([x, y, z], from.toArray(), up * this.orbit.aspect, up);
    this.lookAt(box.getCenter(new Vector3()), distance, from);
    this.fitted = [this.orbit.position.clone(), this.controls.target.clone(), from];
  }

  /** Whether all of it is looked at since nobody has turned the view. */
  private get isFitted(): boolean {
    const [from, to] = this.fitted ?? [];
    return (
      this.isFree &&
      from !== undefined &&
      to !== undefined &&
      from.equals(this.orbit.position) &&
      to.equals(this.controls.target)
    );
  }

  /** Turn to a place and stand so far off [m]. */
  lookAt(place: Vector3, distance: number, from = FROM): void {
    this.orbit.position.copy(place).addScaledVector(from.clone().normalize(), distance);
    this.controls.target.copy(place);
    this.ride(null);
    this.freed.emit();
    this.controls.update();
    this.soon();
  }

  /** Move with a place that is followed. */
  shift(by: Vector3): void {
    this.orbit.position.add(by);
    this.controls.target.add(by);
    this.controls.update();
  }

  /** Look through a camera; null: from where one likes. */
  ride(camera: Camera | null): void {
    this.eye = camera ?? this.orbit;
    this.controls.enabled = camera === null;
    this.soon();
  }

  zoom(factor: number): void {
    const way = this.orbit.position.clone().sub(this.controls.target).multiplyScalar(factor);
    this.orbit.position.copy(this.controls.target).add(way);
    this.controls.update();
    this.soon();
  }

  /** Draw with the next frame of the screen, once. */
  soon(): void {
    this.asked ||= requestAnimationFrame(() => {
      this.asked = 0;
      this.draw();
    });
  }

  /** What lies under a place of the page first. */
  under(clientX: number, clientY: number): Intersection | null {
    this.content.updateMatrixWorld();
    const hits = this.rayAt(clientX, clientY).intersectObject(this.content);
    return hits.find((hit) => hit.object instanceof Mesh) ?? null;
  }

  /** Whether it is looked at from where one likes, not through a camera. */
  get isFree(): boolean {
    return this.eye === this.orbit;
  }

  /** Where on its canvas a place of the world is seen [px]. */
  onCanvas(place: Vector3): Point {
    const { x, y } = place.clone().project(this.orbit);
    return [(0.5 + 0.5 * x) * this.canvas.clientWidth, (0.5 - 0.5 * y) * this.canvas.clientHeight];
  }

  /** Where on the page a place of the world is seen [px]. */
  onPage(place: Vector3): Point {
    const { left, top } = this.canvas.getBoundingClientRect();
    const [x, y] = this.onCanvas(place);
    return [left + x, top + y];
  }

  /** Which place so high [m] is seen at a place of the page; null when none is. */
  onLevel(clientX: number, clientY: number, height: number): Vector3 | null {
    return this.onPlane(clientX, clientY, new Plane(new Vector3(0, 0, 1), -height));
  }

  /** Which place, right above or below another as one looks at it, is seen at a place of the page; null when none is. */
  onUpright(clientX: number, clientY: number, place: Vector3): Vector3 | null {
    const facing = this.orbit.position.clone().sub(place).setZ(0);
    if (facing.lengthSq() < 1e-9) return null;
    return this.onPlane(clientX, clientY, new Plane().setFromNormalAndCoplanarPoint(facing.normalize(), place));
  }

  /** Which place of the plane through another one that faces who looks is seen at a place of the page; null when none is. */
  onFacing(clientX: number, clientY: number, place: Vector3): Vector3 | null {
    const normal = this.orbit.getWorldDirection(new Vector3());
    return this.onPlane(clientX, clientY, new Plane().setFromNormalAndCoplanarPoint(normal, place));
  }

  /** Which place of the line through another one, in a direction of length 1, is seen next to a place of the page. */
  onLine(clientX: number, clientY: number, place: Vector3, way: Vector3): Vector3 | null {
    const facing = this.orbit.position.clone().sub(place);
    facing.addScaledVector(way, -facing.dot(way));
    if (facing.lengthSq() < 1e-9) return null;
    const plane = new Plane().setFromNormalAndCoplanarPoint(facing.normalize(), place);
    const seen = this.onPlane(clientX, clientY, plane);
    return seen && place.clone().addScaledVector(way, seen.sub(place).dot(way));
  }

  private onPlane(clientX: number, clientY: number, plane: Plane): Vector3 | null {
    return this.rayAt(clientX, clientY).ray.intersectPlane(plane, new Vector3());
  }

  private rayAt(clientX: number, clientY: number): Raycaster {
    const box = this.canvas.getBoundingClientRect();
    const at = new Vector2((2 * (clientX - box.left)) / box.width - 1, 1 - (2 * (clientY - box.top)) / box.height);
    const ray = new Raycaster();
    ray.setFromCamera(at, this.eye);
    return ray;
  }

  private draw(): void {
    if (!this.canvas.isConnected || !this.canvas.clientWidth) return;
    // Pictures that wait for each other would come late.
    if (this.busy) return void (this.again = true);
    this.drawing.emit(this.eye);
    this.near();
    // Another size empties the canvas: only right before it is drawn.
    if (this.has !== this.share) this.resize();
    const { eye } = this;
    if (eye instanceof PerspectiveCamera && eye !== this.orbit) this.widen(eye);
    const began = performance.now();
    this.busy = true;
    this.render(!this.isSlow && this.share === 1);
    // What waits for a polished picture says nothing of its own time.
    const waits = this.polishes;
    whenDrawn(this.renderer.getContext() as WebGL2RenderingContext, () =>
      this.done(waits ? null : performance.now() - began),
    );
    window.clearTimeout(this.calm);
    if (this.has < 1 || !this.isShaded) this.calm = window.setTimeout(() => this.sharpen(), CALM);
  }

  /** A picture is there, after so long [ms]; null: nobody knows. */
  private done(took: number | null): void {
    this.busy = false;
    this.canvas.dataset["frames"] = String(++this.drawn);
    if (took !== null) this.pace(took);
    if (this.again) this.soon();
    this.again = false;
  }

  /** Keep the planes of the view near what is looked at, so that surfaces close to each other do not mix. */
  private near(): void {
    const distance = this.orbit.position.distanceTo(this.controls.target);
    this.orbit.near = Math.max(0.01, distance / 200);
    // Includes the whole scene from any place; the precision of depth depends on the near plane.
    this.orbit.far = Math.max(100, 60 * distance, this.orbit.position.distanceTo(this.ball.center) + this.ball.radius);
    this.orbit.updateProjectionMatrix();
  }

  /** Let a robot's camera see as much as it does, and more to the sides where the canvas is wider. */
  private widen(eye: PerspectiveCamera): void {
    eye.aspect = this.canvas.clientWidth / Math.max(this.canvas.clientHeight, 1);
    eye.updateProjectionMatrix();
  }

  /** Choose by how long pictures take [ms] how many pixels the next ones have. */
  private pace(took: number): void {
    this.pacing.add(took, { coarsest: this.share === COARSEST, things: this.things });
    if (took > LONGEST) this.sharp(this.share * 0.85);
    else if (took < SHORTEST && this.share < 1) this.sharp(this.share * 1.05);
  }

  private sharp(share: number): void {
    this.share = Math.min(1, Math.max(COARSEST, share));
  }

  /** Nothing has changed for a while: there is time for all pixels and all light. */
  private sharpen(): void {
    if (this.busy) return;
    this.resize(1);
    this.polishes = true;
    this.render(true);
    whenDrawn(this.renderer.getContext() as WebGL2RenderingContext, () => (this.polishes = false));
  }

  /** Draw a picture; shadows and occlusion are left out where they would make it late. */
  private render(isShaded: boolean): void {
    this.isShaded = this.sky.castShadow = isShaded;
    this.canvas.dataset["shaded"] = String(isShaded);
    if (isShaded && this.eye instanceof PerspectiveCamera) this.shade.render(this.renderer, this.scene, this.eye);
    else this.renderer.render(this.scene, this.eye);
  }

  private resize(share = this.share): void {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (!width || !height) return;
    if (this.orbit.aspect !== width / height) {
      this.orbit.aspect = width / height;
      if (this.isFitted) this.fit(this.fitted?.[2]);
      this.near();
    }
    this.has = share;
    this.renderer.setPixelRatio(share * Math.min(window.devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.canvas.dataset["share"] = share.toFixed(2);
  }

  /** Take up the colours of the theme. */
  recolor(): void {
    this.scene.background = new Color(color("--ground"));
    this.soon();
  }

  private listen(): void {
    const sizes = new ResizeObserver(() => {
      // Another size empties the canvas: it waits for the picture that is being drawn.
      this.has = 0;
      this.draw();
    });
    sizes.observe(this.canvas);
    this.canvas.addEventListener("pointerdown", (event) => (this.pressed = [event.clientX, event.clientY]));
    this.canvas.addEventListener("pointerup", (event) => this.release(event));
    this.canvas.addEventListener("keydown", (event) => this.key(event));
  }

  private release(event: PointerEvent): void {
    const from = this.pressed;
    this.pressed = null;
    // What the view is not turned by is for others.
    if (
      !from ||
      event.button ||
      this.controls.mouseButtons.LEFT === null ||
      Math.hypot(event.clientX - from[0], event.clientY - from[1]) > STILL
    )
      return;
    this.picked.emit(this.under(event.clientX, event.clientY));
  }

  private key(event: KeyboardEvent): void {
    // These belong to the browser: zoom of the page, history.
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const factor = { "+": 0.8, "=": 0.8, "-": 1.25 }[event.key];
    if (factor) this.zoom(factor);
    else if (event.key === "0") this.fit();
    else if (!event.key.startsWith("Arrow")) return;
    event.preventDefault();
    event.stopPropagation();
  }
}
