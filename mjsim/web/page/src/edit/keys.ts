/** The keys of the Edit view: the plan can be worked without a mouse. */

import type { Item, Point } from "../api";
import type { Spot } from "../plan/gestures";
import { isCommand, isSign, isTyping } from "../ui/dom";
import type { Editor } from "./editor";
import type { Tools } from "./tools";

const ARROWS: Record<string, Point> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
/** Arrows with Shift move by so much [m]. */
const FINE = 0.01;
/** Those with Ctrl [m]. */
const FAR = 1;

export class EditKeys {
  /** Where the cross of a tool stands that is moved by keys. */
  private cross: Point | null = null;

  constructor(
    private readonly editor: Editor,
    private readonly tools: Tools,
    private readonly panel: { focus(): void },
    private readonly ways: { toggleText(): void; rename(item: Item): void; menu(): void },
  ) {
    tools.changed.on(() => (this.cross = null));
    editor.plan.host.addEventListener("pointermove", () => (this.cross = null));
    editor.plan.host.addEventListener("keydown", (event) => this.page(event));
    // Before the text sees them: browsers tell it of these while its selection stands, wherever the keyboard is.
    for (const kind of ["copy", "cut", "paste"] as const)
      window.addEventListener(kind, (event) => this.clip(kind, event), { capture: true });
  }

  /** Copy, cut and paste through the clipboard of the system; what is marked in the page as text, and typed, stays text. */
  private clip(kind: "copy" | "cut" | "paste", event: ClipboardEvent): void {
    const { editor } = this;
    const marked = window.getSelection();
    // What is selected in the text of the world stays so while another part of the page has the keyboard.
    const isMarked = marked?.type === "Range" && !marked.anchorNode?.parentElement?.closest(".cm-editor");
    const isText = isTyping(document.activeElement) || (kind !== "paste" && isMarked);
    if (isText || !editor.document.isOpen || !editor.plan.host.isConnected || document.querySelector("dialog[open]"))
      return;
    event.preventDefault();
    event.stopPropagation();
    if (kind === "paste") return void editor.paste(event.clipboardData?.getData("text/plain"));
    const text = editor.copy();
    if (text) event.clipboardData?.setData("text/plain", text);
    if (kind === "cut") void editor.remove();
  }

  /** True when the key was one of ours. */
  key(event: KeyboardEvent): boolean {
    if (!this.editor.document.isOpen) return false;
    if (isCommand(event) && !(event.key in ARROWS)) return this.command(event.key.toLowerCase(), event.shiftKey);
    if (event.altKey && !isSign(event)) return false;
    const onButton =
      event.target instanceof HTMLButtonElement ||
      (event.target instanceof HTMLElement && event.target.tagName === "SUMMARY");
    if (onButton && (event.key === "Enter" || event.key === " ")) return false;
    return this.arrow(event) || this.act(event) || this.editor.plan.key(event) || this.letter(event.key);
  }

  private command(key: string, shift: boolean): boolean {
    const work: Record<string, () => void> = {
      a: () => this.editor.selectAll(),
      d: () => this.editor.duplicate(),
      g: () => void this.editor.group(!shift),
    };
    work[key]?.();
    return key in work;
  }

  private letter(key: string): boolean {
    if (key.toLowerCase() === "y") return (this.ways.toggleText(), true);
    return key.length === 1 && this.tools.takeKey(key);
  }

  private act(event: KeyboardEvent): boolean {
    const { key } = event;
    if (key === "ContextMenu" || (key === "F10" && event.shiftKey)) return (this.ways.menu(), true);
    if (key === "F2") return this.rename();
    if (key === "Escape") return this.escape();
    if (key === "Enter") return this.enter();
    if (key === " " && this.cross) return (this.place(), true);
    if (key === "Delete" || key === "Backspace") return this.remove();
    if (key === "[" || key === "{") return (this.editor.turn(event.shiftKey ? 1 : 15), true);
    if (key === "]" || key === "}") return (this.editor.turn(event.shiftKey ? -1 : -15), true);
    return false;
  }

  private rename(): boolean {
    const [item, ...more] = this.editor.selected;
    if (item && more.length === 0) this.ways.rename(item);
    return true;
  }

  private remove(): boolean {
    if (this.tools.now === "wall" && this.tools.wall.back()) return true;
    if (this.editor.selected.length) void this.editor.remove();
    return true;
  }

  /** Out of what is innermost: the drag, the wall begun, the tool, the selection. */
  private escape(): boolean {
    if (this.editor.plan.cancelDrag()) return true;
    if (this.tools.wall.isDrawing) return (this.tools.wall.cancel(), true);
    if (this.tools.now !== "select") return (this.tools.take("select"), true);
    if (this.editor.selected.length === 0) return false;
    this.editor.select([]);
    return true;
  }

  private enter(): boolean {
    if (this.tools.wall.isDrawing) return (this.tools.wall.finish(false), true);
    if (this.cross) return (this.place(), true);
    if (this.editor.selected.length === 0) return false;
    this.panel.focus();
    return true;
  }

  private arrow(event: KeyboardEvent): boolean {
    const way = ARROWS[event.key];
    if (!way) return false;
    const { plan } = this.editor;
    const far = isCommand(event) ? FAR : event.shiftKey ? FINE : plan.step;
    const by: Point = [way[0] * far, way[1] * far];
    if (this.tools.now === "select" || this.tools.now === "hand") {
      if (this.editor.selected.length === 0) return false;
      this.editor.nudge(by);
      return true;
    }
    const now =
      this.cross ??
      plan
        .toWorld([plan.view.width / 2, plan.view.height / 2])
        .map((value) => Math.round(value / plan.step) * plan.step);
    this.cross = [(now[0] ?? 0) + by[0], (now[1] ?? 0) + by[1]];
    this.tools.tool?.hover?.(this.spot(this.cross));
    this.editor.said.emit(this.cross.map((value) => value.toFixed(2)).join(", "));
    return true;
  }

  private place(): void {
    if (!this.cross) return;
    const spot = this.spot(this.cross);
    this.tools.tool?.down(spot);
    this.tools.tool?.up?.(spot);
  }

  private spot(world: Point): Spot {
    const screen = this.editor.plan.view.toScreen(world);
    return { world, screen, shift: false, alt: false, command: false, touch: false };
  }

  /** From thing to thing on the plan; Tab stops once at all of them, however many there are. */
  private page(event: KeyboardEvent): void {
    const step = ({ PageDown: 1, PageUp: -1 } as const)[event.key];
    if (!step || isCommand(event) || event.altKey) return;
    event.preventDefault();
    const next = this.editor.next(step);
    if (next) this.editor.select([next]);
  }
}
