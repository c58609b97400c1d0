/** Put in a box, a cylinder, a picture or a robot: a click sets it down, a drag gives its size or where it looks. */

import type { Item, Path, Point, Values } from "../api";
import { distance, heading, minus, short } from "../plan/geometry";
import type { Spot, Tool } from "../plan/gestures";
import { drawItem } from "../plan/items";
import type { Plan } from "../plan/plan";
import { ROLES } from "../plan/roles";
import type { PlanShape } from "../run/protocol";
import { word } from "../words/words";
import type { Editor } from "./editor";
import { paintNote } from "./marks";
import { faceNear, isWall, rectangle } from "./shapes";
import { toGrid } from "./snap";

/** What is being put in. */
export interface Piece {
  list: Path;
  value: Values;
  ghost: Item;
  note: string;
}

/** Make it: from where the pointer went down to where it is, or at one point when it did not move. */
export type Make = (editor: Editor, at: Point, to: Point | null, free: boolean) => Piece;

export class PlaceTool implements Tool {
  readonly cursor = "crosshair";
  private piece: Piece | null = null;
  private from: Spot | null = null;
  private screen: Point = [0, 0];

  constructor(
    private readonly editor: Editor,
    private readonly make: Make,
    private readonly placed: (piece: Piece) => void = () => undefined,
  ) {
    editor.plan.overlay.push((context, plan) => plan.tool === this && this.paint(context, plan));
  }

  down(spot: Spot): boolean {
    this.from = spot;
    this.show(spot);
    return true;
  }

  drag(spot: Spot): void {
    this.show(spot);
  }

  hover(spot: Spot): void {
    this.show(spot);
  }

  up(spot: Spot): void {
    this.show(spot);
    this.from = null;
    const { piece } = this;
    if (piece) void this.editor.add(piece.list, piece.value);
    this.leave();
    if (piece) this.placed(piece);
  }

  cancel(): void {
    this.from = null;
    this.leave();
  }

  leave(): void {
    this.piece = null;
    this.editor.plan.drawOver();
  }

  private show(spot: Spot): void {
    const { plan } = this.editor;
    this.screen = spot.screen;
    const snap = (at: Point): Point => (spot.alt ? at : toGrid(at, plan.step));
    const drawn = this.from && distance(this.from.screen, spot.screen) > 5;
    const start = this.from ?? spot;
    this.piece = this.make(this.editor, snap(start.world), drawn ? snap(spot.world) : null, spot.alt);
    plan.drawOver();
  }

  private paint(context: CanvasRenderingContext2D, plan: Plan): void {
    if (!this.piece) return;
    context.globalAlpha = 0.7;
    drawItem(context, this.piece.ghost, plan.view, plan.palette, {});
    context.globalAlpha = 1;
    paintNote(context, plan, this.screen, this.piece.note);
  }
}

/** A rectangle, drawn from corner to corner: `values` are its keys for a length and a width [m]. */
export function sizedMaker(list: Path, kind: string, usual: Point, values: (sides: number[]) => Values): Make {
  return (_editor, at, to) => {
    const sides = to
      ? [Math.abs(to[0] - at[0]) || 0.1, Math.abs(to[1] - at[1]) || 0.1].map((side) => short(side))
      : usual;
    const place: Point = to ? [short((at[0] + to[0]) / 2), short((at[1] + to[1]) / 2)] : at;
    const value = { ...values(sides), at: place };
    const ghost = made(kind, place, 0, [rectangle(place, 0, sides[0] ?? 1, sides[1] ?? 1)], value);
    return { list, value, ghost, note: `${sides.join(" × ")} m` };
  };
}

/** Something round, drawn from its middle: `values` are its keys for a radius [m]. */
export function roundMaker(list: Path, values: (radius: number) => Values): Make {
  return (_editor, at, to) => {
    const radius = to ? Math.max(short(distance(at, to), 2), 0.02) : 0.2;
    const value = { ...values(radius), at };
    return { list, value, ghost: made("obstacle", at, 0, [circle(at, radius)]), note: word("edit.radius", { radius }) };
  };
}

/** Something of a size of its own, about so large [m], drawn to where it looks; what has no size looks nowhere. */
export function turnedMaker(list: Path, kind: string, radius: number, values: () => Values): Make {
  return (editor, at, to) => {
    const turn = to && radius ? Math.round(heading(minus(to, at)) / 5) * 5 : 0;
    const { name, ...rest } = values();
    const named = typeof name === "string" ? { name: editor.freshName(name) } : {};
    const value = { ...named, ...rest, at, ...(turn ? { heading_deg: turn } : {}) };
    const note = radius ? word("edit.looksTo", { turn }) : `${at[0]}, ${at[1]} m`;
    return { list, value, ghost: made(kind, at, turn, radius ? [circle(at, radius)] : [], value), note };
  };
}

export const makeBox = sizedMaker(["obstacles"], "obstacle", [0.6, 0.6], (sides) => ({ box: [...sides, 0.6] }));
export const makeCylinder = roundMaker(["obstacles"], (radius) => ({ cylinder: [radius, 0.8] }));

/** How a picture, a marker or a reflector is put in: on the wall close by, looking into the room. */
export function beaconMaker(look: () => { name: string; value: Values }): Make {
  return (editor, at, to, free) => {
    const { name, value } = look();
    const walls = editor.items.filter(isWall);
    const face = free ? null : faceNear(to ?? at, walls, Math.max(editor.plan.px(40), 0.6));
    const place: Point = face ? [short(face.at[0]), short(face.at[1])] : at;
    const turn = face ? face.heading_deg : to ? Math.round(heading(minus(to, at))) : 0;
    const width = typeof value["width"] === "number" ? value["width"] : 0.6;
    const written = { name: editor.freshName(name), ...value, at: place, ...(turn ? { heading_deg: turn } : {}) };
    const ghost = made("beacon", place, turn, [rectangle(place, turn, 0.02, width)], value);
    return {
      list: ["beacons"],
      value: written,
      ghost,
      note: face ? word("edit.onTheWall", { turn: Math.round(turn) }) : `${place[0]}, ${place[1]} m`,
    };
  };
}

export function robotMaker(look: () => Values): Make {
  return (editor, at, to) => {
    const turn = to ? Math.round(heading(minus(to, at)) / 5) * 5 : 0;
    const { name, ...rest } = look();
    const value = { name: editor.freshName(String(name)), ...rest, at, heading_deg: turn };
    const { preset, sensors, ...place } = value as Values;
    const written = { ...(preset ? { name: place["name"], preset } : {}), ...place, ...(sensors ? { sensors } : {}) };
    return {
      list: ["robots"],
      value: written,
      ghost: made("robot", at, turn, [circle(at, 0.22)]),
      note: word("edit.looksTo", { turn }),
    };
  };
}

/** An item that the server has not drawn yet: its outline, with a tick where it faces. */
function made(kind: string, at: Point, turn: number, polygons: Point[][], values: Values = {}): Item {
  const rest = { path: [], name: null, label: kind, written: [], type: "", fixed: null, origin: null, line: 0 };
  const role = kind in ROLES ? kind : "obstacle";
  const sign: PlanShape = polygons.length
    ? {
        role: "heading",
        anchor: [0, 0, 0],
        parts: [
          [
            [0.3, 0],
            [1.4, 0],
          ],
        ],
      }
    : {
        role: "lamp",
        anchor: [0, 0, 0],
        parts: [
          [
            [1, 0],
            [0, 1],
            [-1, 0],
            [0, -1],
          ],
        ],
        closed: true,
      };
  const shapes = [{ role, count: polygons.length }, sign];
  return { ...rest, kind, at, heading_deg: turn, polygons, shapes, values };
}

function circle([x, y]: Point, radius: number): Point[] {
  const angles = Array.from({ length: 32 }, (_, index) => (index * Math.PI) / 16);
  return angles.map((angle) => [x + radius * Math.cos(angle), y + radius * Math.sin(angle)]);
}
