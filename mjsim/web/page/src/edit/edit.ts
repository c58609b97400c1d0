/** The Edit view: tools, the plan, the text and the panel, side by side. */

import { icon, iconButton, sign } from "../ui/icons";
import "./edit.css";
import "../panel/panel.css";
import type { Item, Point, Values } from "../api";
import { Panel } from "../panel/panel";
import { uploadPicture } from "../panel/pictures";
import { PosturePane } from "../panel/posture";
import { SchemaBook } from "../panel/schema";
import { keyOf, Plan } from "../plan/plan";
import { Door } from "../scene/door";
import type { Studio, View } from "../shell/view";
import { TextPane } from "../text/text";
import { remembered, toggle } from "../ui/controls";
import { el } from "../ui/dom";
import { splitter } from "../ui/splitter";
import { draw, html } from "../ui/view";
import { said, word } from "../words/words";
import { openContextMenu } from "./context_menu";
import { Editor } from "./editor";
import { EditKeys } from "./keys";
import { Outliner } from "./outliner";
import { Panes } from "./panes";
import { Preview } from "./preview";
import { letSidesBeChosen } from "./sides";
import { holdSolids } from "./solid_grip";
import { emptyState } from "./start";
import { Tools } from "./tools";

export function makeEditView(studio: Studio): View {
  const element = el("section", { class: "view edit loading", "aria-label": word("edit.edit") });
  const waiting = el("p", { class: "hint state" });
  draw(waiting, word("edit.loading"));
  element.append(waiting);
  let inner: EditView | null = null;
  const begin = async (): Promise<void> => {
    try {
      const schema = await studio.api.schema();
      element.classList.remove("loading");
      inner = new EditView(studio, element, schema);
    } catch (error) {
      studio.toasts.error(error);
      const view = html`${word("edit.theFormOfWorldsCould")}<button @click=${begin}>${word("edit.tryAgain")}</button>`;
      draw(waiting, view);
    }
  };
  void begin();
  return {
    element,
    shown: () => inner?.shown(),
    hidden: () => undefined,
    key: (event) => inner?.keys.key(event) ?? false,
  };
}

class EditView {
  readonly keys: EditKeys;
  private readonly host = el("div", {
    class: "plan",
    tabindex: 0,
    role: "application",
    "aria-label": word("edit.planOfTheWorld"),
  });
  private readonly plan = new Plan(this.host);
  private readonly editor: Editor;
  private readonly tools: Tools;
  private readonly text: TextPane;
  private readonly panel: Panel;
  private readonly outliner: Outliner;
  private readonly panes: Panes;
  private solidsButton!: HTMLButtonElement;
  /** Counts the worlds that were opened. */
  private world = 0;
  private readonly solids = new Door(
    () => this.studio.api.scene(this.studio.document.path ?? "", this.studio.document.text),
    () => this.studio.askTrust(),
  );
  private readonly problems = el("div", { class: "problems" });
  private readonly firstSteps = el("div", { class: "first-steps", hidden: true });
  private readonly stale = el("p", { class: "stale", hidden: true }, word("edit.theTextCannotBeRead"));
  private readonly dock = el("section", { class: "dock", "aria-label": word("edit.text") });

  constructor(
    private readonly studio: Studio,
    private readonly element: HTMLElement,
    schema: Values,
  ) {
    this.editor = new Editor(studio, this.plan);
    const book = new SchemaBook(schema);
    this.tools = new Tools(this.editor, book);
    this.text = new TextPane(studio.document, book, studio);
    this.panes = new Panes(element, () => this.text.view.requestMeasure());
    this.panel = new Panel(this.editor, book);
    const preview = new Preview(this.editor);
    this.panel.element.append(new PosturePane(this.editor).element, preview.element);
    this.editor.asked.on(() => this.toFields());
    this.outliner = new Outliner(this.editor, book, (at) => this.openMenu(at));
    this.keys = new EditKeys(this.editor, this.tools, this.panel, {
      toggleText: () => this.toggleText(),
      rename: (item) => this.rename(item),
      menu: () => this.openMenu(),
    });
    this.layOut();
    this.listen();
    this.showState();
    this.showProblems();
    this.showFirstSteps();
    this.shown();
  }

  shown(): void {
    const { document } = this.studio;
    if (document.isOpen) this.plan.setItems(document.items, document.parsed.bounds);
    this.showSolids();
    this.text.view.requestMeasure();
  }

  private layOut(): void {
    const toggleText = (): void => this.toggleText();
    const view = html`<header class="dock-head">${sign("text")}<h2>${word("edit.text")}</h2>${this.problems}<span class="space"></span>
        <button class="quiet hide-text" title=${word("edit.hideTheTextY")} @click=${toggleText}>${word("edit.hide")}</button>
        </header>${this.text.element}`;
    draw(this.dock, view);
    const show = el("button", { class: "show-text", title: word("edit.showTheTextY"), onclick: toggleText });
    show.append(icon("text"), word("edit.text"));
    const zoom = el("div", { class: "zoom" });
    draw(zoom, [
      iconButton("plus", word("edit.zoomIn"), () => this.plan.zoomAt(1.25), false, ""),
      iconButton("minus", word("edit.zoomOut"), () => this.plan.zoomAt(0.8), false, ""),
      iconButton("fit", word("edit.showAll2"), () => this.plan.fit(), false, ""),
    ]);
    const said = el("p", { class: "sr", role: "status", "aria-live": "polite" });
    this.editor.said.on((text) => (said.textContent = text));
    const stage = el("div", { class: "stage" }, this.tools.strip, this.host, zoom, show, this.panes.element, said);
    stage.append(this.firstSteps, this.stale, this.solids.element);
    this.tools.strip.append(this.solidsSwitch(stage));
    const side = el("div", { class: "side-column" }, this.outliner.element, this.panel.element);
    const text = {
      label: word("edit.sizeOfTheText"),
      panel: this.dock,
      height: "--text-height",
      width: "--text-width",
    };
    const split = splitter(this.element, text);
    const column = splitter(this.element, { label: word("ui.sizeOfThePanel"), panel: side, width: "--panel" });
    this.element.replaceChildren(this.tools.bar, stage, split, this.dock, column, side, emptyState(this.studio));
    const [head, things] = [this.dock.querySelector("h2"), this.outliner.element.querySelector("button")];
    if (head && things)
      letSidesBeChosen(this.element, { text: head, column: things }, () => this.text.view.requestMeasure());
  }

  /** Opens and shuts the view in 3-D beside the plan. */
  private solidsSwitch(stage: HTMLElement): HTMLElement {
    const open = (on: boolean): void => {
      stage.classList.toggle("with-scene", on);
      this.showSolids();
      this.solids.set(on, this.studio.document.text);
    };
    const was = remembered("edit.scene") === "yes";
    const press = toggle(
      { class: "quiet", title: word("edit.viewInD") },
      was,
      (on) => {
        remembered("edit.scene", on ? "yes" : "no");
        open(on);
      },
      "3-D",
    );
    if (was) open(true);
    this.solidsButton = press;
    return press;
  }

  /** Open the menu of what is selected where it was asked for [px]; by keys, at the thing itself. */
  private openMenu(at?: Point): void {
    const box = this.host.getBoundingClientRect();
    const place = this.editor.selected[0]?.at ?? this.editor.selected[0]?.polygons[0]?.[0];
    const [x, y] = place ? this.plan.view.toScreen(place) : [box.width / 2, box.height / 2];
    const ways = {
      text: (item: Item) => this.goToText(item.line),
      solid: () => this.solidsButton.getAttribute("aria-pressed") === "true" || this.solidsButton.click(),
      rename: (item: Item) => this.rename(item),
      canRename: (item: Item) => this.outliner.canRename(item),
    };
    openContextMenu(this.editor, ways, at ?? [box.left + x, box.top + y]);
  }

  private goToText(line: number): void {
    if (this.panes.takeTurns) this.panes.open("text");
    else if (this.element.classList.contains("no-text")) this.toggleText();
    this.text.goTo(line);
  }

  private toFields(): void {
    this.panes.open("fields");
    this.panel.focus();
  }

  private rename(item: Item): void {
    this.panes.open("fields");
    this.outliner.rename(item);
  }

  private showSolids(): void {
    const { items, selectedItems, isOpen, text } = this.studio.document;
    this.solids.show(items, selectedItems);
    if (isOpen) this.solids.want(text, String(this.world));
  }

  /** Another world: the keyboard goes on at its plan where the button that made it is gone. */
  private begin(): void {
    const { activeElement } = window.document;
    const isGone = activeElement?.closest(".start") !== null && this.element.contains(activeElement);
    this.showState();
    if (isGone) this.host.focus({ preventScroll: true });
  }

  private listen(): void {
    const { document } = this.studio;
    document.opened.on(() => this.begin());
    this.element.addEventListener("keydown", (event) => this.region(event));
    document.parsedChanged.on(() => this.showProblems());
    document.parsedChanged.on(() => this.showFirstSteps());
    document.parsedChanged.on(() => this.showSolids());
    document.selectionChanged.on(() => this.showSolids());
    this.studio.document.opened.on(() => this.world++);
    holdSolids(this.editor, this.tools, this.solids);
    this.solids.chosen.on((item) => this.editor.pick(item ? [item] : []));
    this.tools.changed.on(() => this.showFirstSteps());
    this.plan.menuAsked = (spot, at) => {
      const item = this.plan.itemAt(spot.screen, spot.touch ? 12 : 6);
      const isChosen = this.editor.selected.some((other) => item && keyOf(other.path) === keyOf(item.path));
      if (!isChosen) this.editor.pick(item ? [item] : []);
      this.openMenu(at);
    };
    this.host.addEventListener("dragover", (event) => event.preventDefault());
    this.host.addEventListener("drop", (event) => void this.drop(event));
    this.host.addEventListener(
      "focus",
      () => this.host.matches(":focus-visible") && this.editor.said.emit(word("edit.plan")),
    );
  }

  /** A picture that is dropped on the plan is hung up where it fell. */
  private async drop(event: DragEvent): Promise<void> {
    event.preventDefault();
    const file = event.dataTransfer?.files[0];
    if (!file || !this.studio.document.isOpen) return;
    const box = this.host.getBoundingClientRect();
    const screen: [number, number] = [event.clientX - box.left, event.clientY - box.top];
    const { path: world } = this.studio.document;
    const path = await uploadPicture(this.studio, file);
    if (!path || this.studio.document.path !== world) return;
    const spot = { world: this.plan.toWorld(screen), screen, shift: false, alt: false, command: false, touch: false };
    const hang = this.tools.beaconOf(path);
    hang.down(spot);
    hang.up(spot);
  }

  private showFirstSteps(): void {
    const { document } = this.studio;
    this.stale.hidden = document.parsed.items !== null;
    const wrong = document.parsed.problems.some((problem) => problem.kind === "error");
    this.firstSteps.hidden = document.items.length > 0 || this.tools.now !== "select" || document.parsed.items === null;
    const view = html`<p>${word(wrong ? "edit.nothingOfItCanBe" : "edit.anEmptyFloor")}</p>
        <button class="primary" @click=${() => this.tools.take("wall")}>${sign("wall")}${word("edit.drawTheFirstWallW")}</button>`;
    draw(this.firstSteps, view);
  }

  private showState(): void {
    this.element.classList.toggle("closed", !this.studio.document.isOpen);
  }

  private showProblems(): void {
    const { problems } = this.studio.document.parsed;
    const errors = problems.filter((problem) => problem.kind === "error").length;
    const [first] = problems;
    if (!this.studio.document.isOpen) return;
    if (!first) return draw(this.problems, html`<span class="hint">${word("edit.noProblems")}</span>`);
    const count = [
      errors ? word(errors === 1 ? "edit.oneError" : "edit.errors", { errors }) : "",
      problems.length - errors ? word("edit.toLookAt", { errors: problems.length - errors }) : "",
    ];
    const go = (): void => this.text.goTo(first.line, first.column);
    const text = word("edit.firstProblem", {
      count: count.filter(Boolean).join(", "),
      line: first.line,
      message: said(first.message),
    });
    const view = html`<button class="quiet problem ${first.kind}" title=${word("edit.fGoesToTheNext", { text })} @click=${go}
        >${sign("warning")}<span>${text}</span></button>`;
    draw(this.problems, view);
  }

  /** F6 goes from the tools to the plan, the text and the panel, and round again; with Shift the other way. */
  private region(event: KeyboardEvent): void {
    if (event.key !== "F6") return;
    event.preventDefault();
    const regions: [Element, () => void][] = [
      [this.tools.bar, () => this.tools.bar.querySelector<HTMLElement>("[tabindex='0']")?.focus()],
      [this.host, () => this.host.focus()],
      [this.dock, () => this.text.view.focus()],
      [this.panel.element, () => this.panel.focus()],
    ];
    const shown = regions.filter(([region]) => region.clientHeight > 0);
    const now = shown.findIndex(([region]) => region.contains(document.activeElement));
    const step = event.shiftKey ? -1 : 1;
    shown[(now + step + shown.length) % shown.length]?.[1]();
  }

  private toggleText(): void {
    if (this.panes.takeTurns) return this.panes.turn("text");
    this.element.classList.toggle("no-text");
    this.text.view.requestMeasure();
  }
}
