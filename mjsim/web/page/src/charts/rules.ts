/** Straight lines right across a chart, level or upright. */

import type uPlot from "uplot";

export function across(plot: uPlot, value: number, color: string): void {
  const y = plot.valToPos(value, "y", true);
  stroke(plot.ctx, [plot.bbox.left, y, plot.bbox.left + plot.bbox.width, y], color, 1);
}

export function upright(plot: uPlot, time: number, color: string, width: number): void {
  const x = plot.valToPos(time, "x", true);
  const { left, top, height } = plot.bbox;
  if (x < left - 1 || x > left + plot.bbox.width + 1) return;
  stroke(plot.ctx, [x, top, x, top + height], color, width * devicePixelRatio);
}

function stroke(
  context: CanvasRenderingContext2D,
  [x0, y0, x1, y1]: [number, number, number, number],
  color: string,
  width: number,
): void {
  context.save();
  context.strokeStyle = color;
  context.lineWidth = width;
  context.beginPath();
  context.moveTo(x0, y0);
  context.lineTo(x1, y1);
  context.stroke();
  context.restore();
}
