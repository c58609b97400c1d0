/** Paper with a grid of round metres, and rulers along its upper and left edges. */

import type { Tokens } from "../ui/ink";
import { metres, type PlanView, roundStep } from "./view";

export const RULER = 22;
/** Fine lines are at least this far apart [px]; every fifth or tenth is strong. */
const FINE = 14;
const STRONG = 70;

export function drawGrid(context: CanvasRenderingContext2D, view: PlanView, palette: Tokens): void {
  context.fillStyle = palette.ground;
  context.fillRect(0, 0, view.width, view.height);
  drawLines(context, view, roundStep(view.scale, FINE), palette.grid);
  drawLines(context, view, roundStep(view.scale, STRONG), palette["grid-strong"]);
}

export function drawRulers(context: CanvasRenderingContext2D, view: PlanView, palette: Tokens): void {
  const step = roundStep(view.scale, STRONG);
  context.fillStyle = palette.paper;
  context.fillRect(0, 0, view.width, RULER);
  context.fillRect(0, 0, RULER, view.height);
  context.strokeStyle = palette.hair;
  context.lineWidth = 1;
  stroke(context, [
    [RULER + 0.5, view.height],
    [RULER + 0.5, RULER + 0.5],
    [view.width, RULER + 0.5],
  ]);
  context.fillStyle = palette.muted;
  context.strokeStyle = palette.edge;
  context.font = "11px system-ui, sans-serif";
  context.textBaseline = "middle";
  drawAcross(context, view, step);
  drawDown(context, view, step);
  context.fillStyle = palette.paper;
  context.fillRect(0, 0, RULER, RULER);
  context.fillStyle = palette.muted;
  context.textAlign = "center";
  context.fillText("m", RULER / 2, RULER / 2 + 1);
}

function drawAcross(context: CanvasRenderingContext2D, view: PlanView, step: number): void {
  const [x0, , x1] = view.bounds;
  context.textAlign = "left";
  for (let k = Math.ceil(x0 / (step / 5)); k * (step / 5) <= x1; k++) {
    const x = Math.round(view.left + k * (step / 5) * view.scale) + 0.5;
    if (x < RULER) continue;
    stroke(context, [
      [x, k % 5 === 0 ? RULER - 9 : RULER - 4],
      [x, RULER],
    ]);
    if (k % 5 === 0) context.fillText(metres((k / 5) * step, step), x + 4, RULER / 2 - 1);
  }
}

function drawDown(context: CanvasRenderingContext2D, view: PlanView, step: number): void {
  const [, y0, , y1] = view.bounds;
  for (let k = Math.ceil(y0 / (step / 5)); k * (step / 5) <= y1; k++) {
    const y = Math.round(view.top - k * (step / 5) * view.scale) + 0.5;
    if (y < RULER) continue;
    stroke(context, [
      [k % 5 === 0 ? RULER - 9 : RULER - 4, y],
      [RULER, y],
    ]);
    if (k % 5 !== 0) continue;
    context.save();
    context.translate(RULER / 2 - 1, y - 4);
    context.rotate(-Math.PI / 2);
    context.fillText(metres((k / 5) * step, step), 0, 0);
    context.restore();
  }
}

function drawLines(context: CanvasRenderingContext2D, view: PlanView, step: number, color: string): void {
  const [x0, y0, x1, y1] = view.bounds;
  context.strokeStyle = color;
  context.lineWidth = 1;
  context.beginPath();
  for (let k = Math.ceil(x0 / step); k * step <= x1; k++) {
    const x = Math.round(view.left + k * step * view.scale) + 0.5;
    context.moveTo(x, 0);
    context.lineTo(x, view.height);
  }
  for (let k = Math.ceil(y0 / step); k * step <= y1; k++) {
    const y = Math.round(view.top - k * step * view.scale) + 0.5;
    context.moveTo(0, y);
    context.lineTo(view.width, y);
  }
  context.stroke();
}

function stroke(context: CanvasRenderingContext2D, points: [number, number][]): void {
  context.beginPath();
  for (const [x, y] of points) context.lineTo(x, y);
  context.stroke();
}
