/** One picture on the page: a canvas that shows the newest JPEG, with what was recognised in it. */

import { readTokens } from "../ui/ink";
import { Rate } from "./frames";
import type { FrameHead } from "./protocol";

type Recognised = FrameHead["recognised"];

/** Shows pictures of one view; those that come while one is decoded wait, the newest alone. */
export class Screen {
  readonly canvas = document.createElement("canvas");
  readonly rate = new Rate();
  /** Simulated time of the picture that is shown [s]; null before the first. */
  time: number | null = null;
  private busy = false;
  private next: { head: FrameHead; jpeg: Blob } | null = null;
  private ratio = 1;

  constructor(
    label: string,
    /** Told once a picture stands on the page, or was passed over for a newer one. */
    private readonly shown: (head: FrameHead) => void,
  ) {
    this.canvas.className = "run-screen";
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", label);
    this.shape(640, 480);
    new ResizeObserver(() => this.measure()).observe(this.canvas);
  }

  /** Take the shape of the pictures that will come [px]. */
  shape(width: number, height: number): void {
    this.canvas.width = width;
    this.canvas.height = height;
  }

  show(head: FrameHead, jpeg: Blob): void {
    if (this.next) this.shown(this.next.head);
    this.next = { head, jpeg };
    if (!this.busy) void this.work();
  }

  /** Forget the picture, as when a new run begins. */
  clear(): void {
    this.time = null;
    this.canvas.getContext("2d")?.clearRect(0, 0, this.canvas.width, this.canvas.height);
    this.canvas.toggleAttribute("data-filled", false);
  }

  private async work(): Promise<void> {
    this.busy = true;
    for (let each = this.take(); each; each = this.take()) {
      // A picture that cannot be decoded is passed over; the next one will do.
      const bitmap = await createImageBitmap(each.jpeg).catch(() => null);
      if (bitmap) this.paint(bitmap, each.head);
      this.shown(each.head);
    }
    this.busy = false;
  }

  private take(): { head: FrameHead; jpeg: Blob } | null {
    const each = this.next;
    this.next = null;
    return each;
  }

  private paint(bitmap: ImageBitmap, head: FrameHead): void {
    if (this.canvas.width !== bitmap.width || this.canvas.height !== bitmap.height) {
      this.shape(bitmap.width, bitmap.height);
      this.measure();
    }
    const context = this.canvas.getContext("2d");
    if (!context) return;
    context.drawImage(bitmap, 0, 0);
    bitmap.close();
    drawRecognised(context, head.recognised, this.ratio);
    this.time = head.time;
    this.canvas.toggleAttribute("data-filled", true);
    this.rate.count();
  }

  /** Learn how many pixels of the picture one of the page takes: letters keep their size. */
  private measure(): void {
    this.ratio = pixelRatio(this.canvas);
  }
}

/** A rectangle on the picture [px]. */
interface Plate {
  x: number;
  y: number;
  width: number;
  height: number;
}

/** How many pixels of a picture one of the page takes where it is shown; 1 at least. */
export function pixelRatio(canvas: HTMLCanvasElement): number {
  const { width, height, clientWidth, clientHeight } = canvas;
  return clientWidth && clientHeight ? Math.max(1, width / clientWidth, height / clientHeight) : 1;
}

/** Outline what was recognised and write its name on a plate above it, where there is room. */
export function drawRecognised(context: CanvasRenderingContext2D, found: Recognised, ratio: number): void {
  const { seen, paper } = readTokens();
  context.lineJoin = "round";
  for (const [, corners] of found) {
    const outline = new Path2D();
    // Pixel centres lie at whole numbers in the message, and half a pixel further on the canvas.
    for (const [x, y] of corners) outline.lineTo(x + 0.5, y + 0.5);
    outline.closePath();
    stroke(context, outline, 4 * ratio, paper);
    stroke(context, outline, 2 * ratio, seen);
  }
  const plates: Plate[] = [];
  // What is near is large, and is named first.
  for (const [name, corners] of [...found].sort((a, b) => heightOf(b[1]) - heightOf(a[1]))) {
    const plate = name === null ? null : plateOf(context, name, corners, ratio, plates);
    if (name === null || !plate) continue;
    plates.push(plate);
    drawPlate(context, name, plate, ratio, seen, paper);
  }
}

function heightOf(corners: [number, number][]): number {
  const rows = corners.map((corner) => corner[1]);
  return Math.max(...rows) - Math.min(...rows);
}

function stroke(context: CanvasRenderingContext2D, path: Path2D, width: number, color: string): void {
  context.lineWidth = width;
  context.strokeStyle = color;
  context.stroke(path);
}

/** Where a name goes: above what it names, or below; null where others stand. */
function plateOf(
  context: CanvasRenderingContext2D,
  name: string,
  corners: [number, number][],
  ratio: number,
  taken: Plate[],
): Plate | null {
  const size = 12 * ratio;
  context.font = `600 ${size}px system-ui, sans-serif`;
  const width = context.measureText(name).width + size;
  const height = size * 1.5;
  const middle = corners.reduce((sum, corner) => sum + corner[0], 0) / corners.length;
  const rows = corners.map((corner) => corner[1]);
  const x = Math.min(Math.max(middle - width / 2, 0), context.canvas.width - width);
  const above = Math.max(Math.min(...rows) - height - 3 * ratio, 0);
  const below = Math.min(Math.max(...rows) + 3 * ratio, context.canvas.height - height);
  const free = (y: number): boolean =>
    taken.every(
      (other) =>
        y >= other.y + other.height || other.y >= y + height || x >= other.x + other.width || other.x >= x + width,
    );
  const y = [above, below].find(free);
  return y === undefined ? null : { x, y, width, height };
}

function drawPlate(
  context: CanvasRenderingContext2D,
  name: string,
  { x, y, width, height }: Plate,
  ratio: number,
  color: string,
  paper: string,
): void {
  context.fillStyle = color;
  context.beginPath();
  context.roundRect(x, y, width, height, 3 * ratio);
  context.fill();
  context.fillStyle = paper;
  context.textBaseline = "middle";
  context.fillText(name, x + 6 * ratio, y + height / 2 + ratio / 2);
}
