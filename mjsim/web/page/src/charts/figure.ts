/** Curves with axes as vectors: drawn in the page, and given away as SVG or PNG on white. */

import { faded } from "../ui/ink";
import { save } from "./save";

/** Of the small print, at most on average [px]. */
const WIDTH_OF_LETTER = 6.3;

type Values = ArrayLike<number | null | undefined>;
type Range = [number, number];

export interface Curve {
  label: string;
  color: string;
  width?: number;
  dash?: number[];
  x: Values;
  y: Values;
  /** The area from the curve to these values is filled. */
  to?: Values;
  /** Of that area: '#rrggbbaa'. */
  fill?: string;
}

export interface Figure {
  title: string;
  x: string;
  y: string;
  curves: Curve[];
  /** Areas behind all curves, such as walls. */
  shapes?: { points: [number, number][]; fill: string }[];
  /** What the axes show. */
  xRange: Range;
  yRange: Range;
  /** The y axis is linear up to 1, logarithmic beyond. */
  logarithmic?: boolean;
  /** A metre is as long in both axes. */
  equal?: boolean;
  /** A band behind all curves, a line across, and their colour. */
  band?: Range;
  across?: number;
  behind?: string;
  ink: Ink;
}

/** Colours of what is no curve. */
export interface Ink {
  paper: string;
  text: string;
  grid: string;
}

export interface Drawing {
  svg: SVGSVGElement;
  /** Pixel of a point. */
  place(x: number, y: number): [number, number];
}

/** Of a figure that is given away [px]; one whose axes have one scale is higher. */
const SIZE: [number, number] = [760, 400];
const HIGH: [number, number] = [760, 640];
/** A PNG has so many pixels for each of them. */
const SHARP = 2;
const SPACE = "http://www.w3.org/2000/svg";
const ROOM = { left: 58, right: 14, top: 14, bottom: 40, title: 24, line: 18 };
const FONT = "system-ui, 'Segoe UI', 'Helvetica Neue', 'DejaVu Sans', sans-serif";

/** Draw a figure of so many pixels; without its title where the page has one beside it. */
export function drawFigure(figure: Figure, [width, height] = sizeOf(figure), titled = true): Drawing {
  const labelled = titled ? figure.curves.filter(({ label }) => label) : [];
  const rows = titled ? legendRows(labelled, width) : [];
  const top = ROOM.top + (titled ? ROOM.title + rows.length * ROOM.line : 0);
  const box = {
    left: ROOM.left,
    top,
    width: Math.max(width - ROOM.left - ROOM.right, 10),
    height: Math.max(height - top - ROOM.bottom, 10),
  };
  const [xRange, yRange] = figure.equal ? equalised(figure, box) : [figure.xRange, figure.yRange];
  const bend = figure.logarithmic ? Math.asinh : (value: number): number => value;
  const along = (value: number, [low, high]: Range): number => (value - low) / (high - low || 1);
  const place = (x: number, y: number): [number, number] => [
    box.left + box.width * along(x, xRange),
    box.top + box.height * (1 - along(bend(y), [bend(yRange[0]), bend(yRange[1])])),
  ];
  const svg = node("svg", { xmlns: SPACE, width, height, viewBox: `0 0 ${width} ${height}`, "font-family": FONT });
  const clip = `clip-${(clips += 1)}`;
  const inside = node("g", { "clip-path": `url(#${clip})` });
  const frame = { x: box.left, y: box.top, width: box.width, height: box.height };
  svg.append(
    wrapped("defs", wrapped("clipPath", node("rect", frame), { id: clip })),
    node("rect", { width, height, fill: figure.ink.paper }),
  );
  if (titled)
    svg.append(text(figure.title, { x: ROOM.left, y: 24, "font-size": 15, "font-weight": 600, fill: figure.ink.text }));
  svg.append(...legend(rows, figure.ink));
  svg.append(...axes(figure, { xRange, yRange, frame, place }), inside);
  if (figure.band) inside.append(bandOf(figure, frame, place));
  if (figure.across !== undefined) {
    const y = place(0, figure.across)[1];
    inside.append(
      node("path", {
        d: `M${frame.x} ${round(y)}h${frame.width}`,
        stroke: figure.behind ?? figure.ink.text,
        fill: "none",
      }),
    );
  }
  for (const { points, fill } of figure.shapes ?? []) inside.append(shapeOf(points, fill, place));
  for (const curve of figure.curves) if (curve.to) inside.append(area(curve, place));
  for (const curve of figure.curves) inside.append(line(curve, place));
  return { svg, place };
}

let clips = 0;

export function saveSvg(figure: Figure): void {
  save(new Blob([svgText(figure)], { type: "image/svg+xml" }), `${fileName(figure.title)}.svg`);
}

export async function savePng(figure: Figure): Promise<void> {
  const address = URL.createObjectURL(new Blob([svgText(figure)], { type: "image/svg+xml" }));
  try {
    const picture = new Image();
    picture.src = address;
    await picture.decode();
    const [width, height] = sizeOf(figure);
    const canvas = Object.assign(document.createElement("canvas"), { width: width * SHARP, height: height * SHARP });
    canvas.getContext("2d")?.drawImage(picture, 0, 0, canvas.width, canvas.height);
    canvas.toBlob((blob) => blob && save(blob, `${fileName(figure.title)}.png`));
  } finally {
    URL.revokeObjectURL(address);
  }
}

/** A title as the name of a file. */
export function fileName(title: string): string {
  return (
    title
      .toLowerCase()
      .replace(/[^a-z0-9]+/g, "-")
      .replace(/^-+|-+$/g, "") || "chart"
  );
}

/** What values lie between, with some room; of none, 0 to 1. */
export function rangeOf(columns: Values[]): Range {
  let [low, high] = [Number.POSITIVE_INFINITY, Number.NEGATIVE_INFINITY];
  for (const column of columns)
    for (let k = 0; k < column.length; k += 1) {
      const value = column[k];
      if (typeof value !== "number") continue;
      low = Math.min(low, value);
      high = Math.max(high, value);
    }
  if (low > high) return [0, 1];
  const room = 0.05 * (high - low) || 0.05 * Math.abs(high) || 0.5;
  return [low - room, high + room];
}

function sizeOf({ equal }: Figure): [number, number] {
  return equal ? HIGH : SIZE;
}

function svgText(figure: Figure): string {
  return `<?xml version="1.0" encoding="UTF-8"?>\n${new XMLSerializer().serializeToString(drawFigure(figure).svg)}\n`;
}

type Place = Drawing["place"];
interface Frame {
  x: number;
  y: number;
  width: number;
  height: number;
}

function axes(
  figure: Figure,
  { xRange, yRange, frame, place }: { xRange: Range; yRange: Range; frame: Frame; place: Place },
): SVGElement[] {
  const { text: fill, grid } = figure.ink;
  const [bottom, middle] = [frame.y + frame.height, frame.x + frame.width / 2];
  const drawn: SVGElement[] = [];
  const small = { "font-size": 11, fill };
  for (const value of ticks(xRange, frame.width / 80)) {
    const x = round(place(value, yRange[0])[0]);
    drawn.push(node("path", { d: `M${x} ${frame.y}v${frame.height}`, stroke: grid }));
    drawn.push(text(short(value), { ...small, x, y: bottom + 15, "text-anchor": "middle" }));
  }
  const rows = figure.logarithmic ? decades(yRange) : ticks(yRange, frame.height / 34);
  for (const value of rows) {
    const y = round(place(xRange[0], value)[1]);
    drawn.push(node("path", { d: `M${frame.x} ${y}h${frame.width}`, stroke: grid }));
    drawn.push(text(short(value), { ...small, x: frame.x - 6, y: y + 4, "text-anchor": "end" }));
  }
  const aside = `rotate(-90 14 ${frame.y + frame.height / 2})`;
  drawn.push(text(figure.x, { ...small, x: middle, y: bottom + 32, "text-anchor": "middle" }));
  drawn.push(
    text(tail(figure.y, frame.y + frame.height), {
      ...small,
      x: 14,
      y: frame.y + frame.height / 2,
      "text-anchor": "middle",
      transform: aside,
    }),
  );
  return drawn;
}

/** A label as its end that is no longer than so much [px] in the small print: names of fields differ in their last parts. */
function tail(label: string, room: number): string {
  const most = Math.floor(room / WIDTH_OF_LETTER);
  return label.length <= most ? label : `…${label.slice(1 - most)}`;
}

function bandOf({ band = [0, 0], behind }: Figure, frame: Frame, place: Place): SVGElement {
  const [top, bottom] = [place(0, band[1])[1], place(0, band[0])[1]];
  const fill = behind ? faded(behind, 0.18) : "none";
  return node("rect", { x: frame.x, y: round(top), width: frame.width, height: round(bottom - top), fill });
}

function shapeOf(points: [number, number][], fill: string, place: Place): SVGElement {
  const corners = points.map(([x, y]) => place(x, y).map(round).join(" "));
  return node("path", { d: `M${corners.join("L")}Z`, fill });
}

/** A curve, broken where a value is not known; where there is no value at all the one before goes on. */
function line(curve: Curve, place: Place): SVGElement {
  return node("path", {
    d: pieces(curve.x, curve.y, place)
      .map((piece) => `M${piece.join("L")}`)
      .join(""),
    fill: "none",
    stroke: curve.color,
    "stroke-width": curve.width ?? 1.5,
    "stroke-linejoin": "round",
    ...(curve.dash ? { "stroke-dasharray": curve.dash.join(" ") } : {}),
  });
}

function area(curve: Curve, place: Place): SVGElement {
  const to = pieces(curve.x, curve.to ?? [], place);
  const shapes = pieces(curve.x, curve.y, place).map(
    (piece, k) => `M${[...piece, ...(to[k] ?? []).reverse()].join("L")}Z`,
  );
  return node("path", { d: shapes.join(""), fill: curve.fill ?? "none" });
}

function pieces(xs: Values, ys: Values, place: Place): string[][] {
  const found: string[][] = [];
  let now: string[] | null = null;
  for (let k = 0; k < xs.length; k += 1) {
    const [x, y] = [xs[k], ys[k]];
    if (x === undefined || y === undefined) continue;
    if (x === null || y === null) {
      now = null;
      continue;
    }
    if (!now) found.push((now = []));
    const [across, down] = place(x, y);
    now.push(`${round(across)} ${round(down)}`);
  }
  return found;
}

/** Entries of the legend, row by row. */
function legendRows(curves: Curve[], width: number): { curve: Curve; x: number }[][] {
  const rows: { curve: Curve; x: number }[][] = [];
  let x = Number.POSITIVE_INFINITY;
  for (const curve of curves) {
    const wide = 38 + 6.4 * curve.label.length;
    if (x + wide > width - ROOM.right) {
      rows.push([]);
      x = ROOM.left;
    }
    rows[rows.length - 1]?.push({ curve, x });
    x += wide;
  }
  return rows;
}

function legend(rows: ReturnType<typeof legendRows>, { text: fill }: Ink): SVGElement[] {
  return rows.flatMap((row, k) =>
    row.flatMap(({ curve, x }) => {
      const y = 24 + (k + 1) * ROOM.line;
      const dash: Record<string, string> = curve.dash ? { "stroke-dasharray": curve.dash.join(" ") } : {};
      const stroke = node("path", { d: `M${x} ${y - 4}h20`, stroke: curve.color, "stroke-width": 2.5, ...dash });
      return [stroke, text(curve.label, { x: x + 26, y, "font-size": 12, fill })];
    }),
  );
}

/** Widen what one axis shows, so that a metre is as long in both. */
function equalised({ xRange, yRange }: Figure, box: { width: number; height: number }): [Range, Range] {
  const scale = Math.max((xRange[1] - xRange[0]) / box.width, (yRange[1] - yRange[0]) / box.height) || 1;
  const about = ([low, high]: Range, pixels: number): Range => {
    const [middle, half] = [(low + high) / 2, (scale * pixels) / 2];
    return [middle - half, middle + half];
  };
  return [about(xRange, box.width), about(yRange, box.height)];
}

/** Round numbers in a range, about so many. */
function ticks([low, high]: Range, count: number): number[] {
  const rough = (high - low) / Math.max(count, 2.5);
  if (!(rough > 0) || !Number.isFinite(rough)) return [low];
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * ([1, 2, 5, 10].find((each) => each * power >= rough) ?? 10);
  const first = Math.ceil(low / step);
  const most = Math.floor(high / step + 1e-9) - first + 1;
  return Array.from({ length: Math.max(Math.min(most, 100), 0) }, (_, k) => (first + k) * step);
}

function decades([low, high]: Range): number[] {
  const found = [0];
  for (let power = 1; power <= high; power *= 10) found.push(power, ...[2, 5].map((each) => each * power));
  return found
    .filter((value) => value >= low && value <= high)
    .filter((value, _, all) => all.length < 9 || /^[01]/.test(String(value)));
}

/** Format a number without rounding errors; ticks of large numbers, such as UTM coordinates, stay distinct. */
function short(value: number): string {
  const rounded = Number(value.toPrecision(12));
  // -0.000004 would not fit beside its axis.
  return rounded !== 0 && Math.abs(rounded) < 1e-3 ? rounded.toExponential() : String(rounded);
}

function round(value: number): number {
  return Math.round(value * 100) / 100;
}

function node(name: string, attributes: Record<string, string | number>): SVGSVGElement {
  const element = document.createElementNS(SPACE, name);
  for (const [key, value] of Object.entries(attributes)) if (key !== "xmlns") element.setAttribute(key, String(value));
  return element as SVGSVGElement;
}

function wrapped(name: string, child: SVGElement, attributes: Record<string, string> = {}): SVGElement {
  const element = node(name, attributes);
  element.append(child);
  return element;
}

function text(content: string, attributes: Record<string, string | number>): SVGElement {
  const element = node("text", attributes);
  element.textContent = content;
  return element;
}
