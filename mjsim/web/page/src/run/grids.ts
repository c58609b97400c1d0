/** Grids that modules show, as pictures: decoded once, and kept as long as they are shown. */

import type { ShownNews } from "./protocol";

/** So many are kept. */
const MOST = 32;
/** What the grey level of a cell means: from 0, occupied, to this, free; beyond it is not known. */
const FREE = 254;
/** How solid a cell is drawn, on a scale to 255. */
const SOLID = 205;

/** Pictures of grids by their cells and colour; null while one is being decoded. */
export class Grids {
  private readonly made = new Map<string, HTMLCanvasElement | null>();

  constructor(
    /** Told when one has been decoded. */
    private readonly ready: () => void,
  ) {}

  of({ png = "", color }: ShownNews): HTMLCanvasElement | null {
    const key = color + png;
    const found = this.made.get(key);
    if (found !== undefined) {
      // What was not shown for longest goes first.
      this.made.delete(key);
      this.made.set(key, found);
      return found;
    }
    this.made.set(key, null);
    const [oldest] = this.made.keys();
    if (this.made.size > MOST && oldest !== undefined) this.made.delete(oldest);
    void this.make(key, png, color);
    return null;
  }

  private async make(key: string, png: string, color: string): Promise<void> {
    const bytes = Uint8Array.from(atob(png), (letter) => letter.charCodeAt(0));
    const bitmap = await createImageBitmap(new Blob([bytes], { type: "image/png" })).catch(() => null);
    if (!bitmap || !this.made.has(key)) return;
    this.made.set(key, colored(bitmap, color));
    bitmap.close();
    this.ready();
  }
}

/** White where it is free, the colour where it is occupied, nothing where it is not known. */
function colored(bitmap: ImageBitmap, color: string): HTMLCanvasElement {
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [bitmap.width, bitmap.height];
  const context = canvas.getContext("2d");
  if (!context) return canvas;
  context.drawImage(bitmap, 0, 0);
  const image = context.getImageData(0, 0, canvas.width, canvas.height);
  const full = [1, 3, 5].map((k) => parseInt(color.slice(k, k + 2), 16));
  const { data } = image;
  for (let k = 0; k < data.length; k += 4) {
    const level = data[k] ?? FREE;
    const share = level > FREE ? 0 : 1 - level / FREE;
    for (let c = 0; c < 3; c++) data[k + c] = 255 + share * ((full[c] ?? 0) - 255);
    data[k + 3] = level > FREE ? 0 : SOLID;
  }
  context.putImageData(image, 0, 0);
  return canvas;
}
