/** A canvas that fills the paper of a plan, painted with the next frame of the screen when something has changed. */

type Paint = (context: CanvasRenderingContext2D) => void;

export class Layer {
  readonly element = document.createElement("canvas");
  private readonly context = this.element.getContext("2d");
  private frame = 0;

  constructor(private readonly paint: Paint) {}

  /** Take a size [px]; the browser's zoom changes the pixel ratio, too. */
  resize(width: number, height: number): void {
    const { element } = this;
    element.width = Math.round(width * window.devicePixelRatio);
    element.height = Math.round(height * window.devicePixelRatio);
    Object.assign(element.style, { width: `${width}px`, height: `${height}px` });
    this.draw(); // what has another size is empty: it is painted before the screen shows it
  }

  /** Paint anew, once a frame. */
  drawSoon(): void {
    this.frame ||= requestAnimationFrame(() => this.draw());
  }

  close(): void {
    cancelAnimationFrame(this.frame);
    this.element.remove();
  }

  private draw(): void {
    cancelAnimationFrame(this.frame);
    this.frame = 0;
    const { context, element } = this;
    if (!context) return;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, element.width, element.height);
    context.scale(window.devicePixelRatio, window.devicePixelRatio);
    context.save();
    this.paint(context);
    context.restore();
  }
}
