/** What the camera of the selected robot would see; follows the drag. */

import type { Item, PreviewAsk, Values } from "../api";
import { ApiError } from "../api";
import { el } from "../ui/dom";
import { newestWins } from "../ui/signal";
import { draw, html, namesToChoose, nothing } from "../ui/view";
import { word } from "../words/words";
import type { Editor } from "./editor";

const WIDTH = 320;

export class Preview {
  readonly element = el("figure", { class: "preview", hidden: true });
  private readonly picture = el("img", { alt: "" });
  private readonly caption = el("figcaption", {});
  private readonly choice = el("select", { "aria-label": word("edit.camera") });
  private readonly wanted: (ask: PreviewAsk) => void;
  private last = "";
  /** Whose camera the picture is of, or will be. */
  private subject = "";
  private ghosts: Item[] = [];

  constructor(private readonly editor: Editor) {
    this.element.append(
      el("div", { class: "preview-head" }, el("span", {}, word("edit.camera")), this.choice),
      this.picture,
      this.caption,
    );
    this.wanted = newestWins((ask: PreviewAsk) => this.load(ask));
    this.choice.addEventListener("change", () => this.draw());
    editor.document.parsedChanged.on(() => this.draw());
    editor.document.selectionChanged.on(() => this.draw());
    editor.dragged.on((ghosts) => {
      this.ghosts = ghosts;
      this.draw();
    });
  }

  private draw(): void {
    const robot = this.robot();
    const cameras = robot ? camerasOf(robot.values) : [];
    this.element.hidden = cameras.length === 0;
    if (!robot?.name || !robot.at || cameras.length === 0) return;
    draw(this.choice, namesToChoose(cameras, this.choice.value));
    const { document } = this.editor;
    const camera = this.choice.value;
    const ask = {
      path: document.path ?? "",
      text: document.text,
      robot: robot.name,
      camera,
      at: robot.at,
      heading_deg: robot.heading_deg ?? 0,
      width: WIDTH,
    };
    const key = JSON.stringify([ask, this.editor.studio.api.version]);
    if (key === this.last) return;
    this.last = key;
    const subject = subjectOf(ask);
    if (subject !== this.subject) this.clear();
    this.subject = subject;
    if (!this.picture.hasAttribute("src")) draw(this.caption, word("edit.drawing"));
    this.picture.alt = word("edit.whatCameraOfSees", { camera, name: robot.name });
    this.wanted(ask);
  }

  /** Take away a picture of another camera. */
  private clear(): void {
    if (this.picture.src.startsWith("blob:")) URL.revokeObjectURL(this.picture.src);
    this.picture.removeAttribute("src");
  }

  private robot(): Item | null {
    const [only, more] = this.editor.selected;
    if (!only || more || only.type !== "Robot") return null;
    return this.ghosts.find((ghost) => ghost.type === "Robot" && ghost.name === only.name) ?? only;
  }

  private async load(ask: PreviewAsk): Promise<void> {
    try {
      const picture = await this.editor.studio.api.preview(ask);
      if (subjectOf(ask) !== this.subject) return;
      this.clear();
      this.picture.src = URL.createObjectURL(picture);
      draw(this.caption, nothing);
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      if (subjectOf(ask) !== this.subject) return;
      this.last = ""; // asked for again when something changes
      this.explain(error, ask);
    }
  }

  private explain(error: ApiError, ask: PreviewAsk): void {
    if (error.data["superseded"] === true) return;
    const allow = async (): Promise<void> => {
      if (await this.editor.studio.askTrust()) this.wanted(ask);
    };
    const needsTrust = error.data["needs_trust"] !== undefined;
    const look = html`<button @click=${allow}>${word("edit.lookAtWhatItIs")}</button>`;
    draw(this.caption, [error.message, needsTrust ? look : nothing]);
  }
}

function subjectOf({ path, robot, camera }: PreviewAsk): string {
  return JSON.stringify([path, robot, camera]);
}

export function camerasOf(values: Values): string[] {
  const sensors = Array.isArray(values["sensors"]) ? (values["sensors"] as Values[]) : [];
  return sensors.map((sensor) => sensor["camera"]).filter((name) => typeof name === "string");
}
