/** All that is seen of a recording, at one time of it. */

import { ApiError } from "../api";
import type { Marks } from "../charts/chart";
import { chartChips } from "../charts/chips";
import { Plotter } from "../charts/plotter";
import { rowAt } from "../charts/rows";
import { type Kind, kindsOf, Sheet } from "../charts/sheet";
import { clock } from "../run/bar";
import { EventList } from "../run/events";
import { Floor } from "../run/floor";
import { JointStates } from "../run/joint_states";
import type { RobotTick } from "../run/protocol";
import { RunRecord } from "../run/record";
import { SolidsTile } from "../scene/tile";
import type { Studio, View } from "../shell/view";
import { columns } from "../ui/columns";
import { button, write } from "../ui/controls";
import { el } from "../ui/dom";
import { iconButton } from "../ui/icons";
import { newestWins } from "../ui/signal";
import { Tabs } from "../ui/tabs";
import { Stage } from "../ui/tile";
import { choice, type View as Drawn, draw, html, namesToChoose, nothing } from "../ui/view";
import { word } from "../words/words";
import { Compare, drawPlay } from "./compare";
import { Film } from "./film";
import { Library } from "./library";
import { Looked, type Part, UNMARKED } from "./looked";
import { RecordedNumbers } from "./numbers";
import { Pictures } from "./pictures";
import { NOTHING, type Recording, recordings } from "./recording";
import { Scrub } from "./scrub";
import { Table } from "./table";

const SPEEDS = [
  ["0.25", "¼ ×"],
  ["0.5", "½ ×"],
  ["1", "1 ×"],
  ["2", "2 ×"],
  ["4", "4 ×"],
  ["10", "10 ×"],
] as const;
const FIRST_CHARTS: Kind[] = ["distance", "x", "y", "heading", "nees"];

export class ReviewView implements View {
  readonly element = el("section", { class: "view review", "aria-label": word("review.review") });
  private readonly looked = new Looked();
  private readonly player = this.looked.player;
  private readonly record = new RunRecord();
  private readonly whole = new RunRecord();
  private readonly floor = new Floor(this.record);
  private readonly stage = new Stage("review.stage");
  private readonly pictures = new Pictures(this.looked, () => this.arrange());
  private readonly solids = new SolidsTile(
    "review.scene",
    () => recordings.scene(this.looked.recording?.path ?? ""),
    () => this.arrange(),
  );
  private readonly scrub = new Scrub((time) => this.player.seek(time));
  private readonly film = new Film(this.looked);
  private readonly events = new EventList(word("review.nothingHappenedInThisRecording"), (time) =>
    this.player.seek(time),
  );
  private readonly joints = new JointStates();
  private readonly table: Table;
  private readonly library: Library;
  private readonly compare: Compare;
  private readonly tabs: Tabs;
  private readonly sheet: Sheet;
  private readonly plotter: Plotter;
  private readonly numbers = new RecordedNumbers(() => this.looked.recording?.path ?? "");
  private readonly robot = el("select", {
    "aria-label": word("review.robot"),
    hidden: true,
    onchange: () => this.choose(this.robot.value),
  });
  private readonly playButton = button({ class: "primary run-main", title: word("review.playSpace") }, () =>
    this.player.toggle(),
  );
  private readonly time = el("output", { class: "run-value run-time" }, "–");
  private readonly title = el("strong", { class: "review-title" }, word("review.noRecording"));
  private readonly cut = el(
    "span",
    { class: "run-state", "data-state": "paused", hidden: true },
    word("review.endsEarlyCutOff"),
  );
  private readonly empty = el("div", { class: "state" });
  private readonly content: HTMLElement;
  /** Whether the figures of the part are there. */
  private figured = false;
  /** How many recordings have been asked for. */
  private turn = 0;
  private readonly askTick = newestWins((time: number) => this.fetchTick(time));
  private readonly askFigures = newestWins((part: Part) => this.fetchFigures(part));

  constructor(private readonly studio: Studio) {
    this.table = new Table((text) => this.studio.toasts.done(text));
    this.library = new Library(
      studio,
      () => this.looked.recording?.path,
      (path) => void this.open(path),
      (paths) => this.compare.open(paths),
    );
    const handlers = {
      pick: (time: number) => this.player.seek(time),
      select: (from: number, to: number) => this.mark({ from, to }),
    };
    this.sheet = new Sheet(FIRST_CHARTS, handlers, "review");
    const fail = (error: unknown): void => this.studio.toasts.error(error);
    this.plotter = new Plotter(this.sheet.element, "review", this.numbers, handlers, fail);
    this.tabs = new Tabs("review.tab", [
      ["recordings", word("review.recordings"), this.library.element],
      ["figures", word("review.figures"), el("div", {}, this.table.element, this.film.element)],
      ["joints", word("run.joints"), this.joints.element],
      ["plot", word("review.plot"), this.plotter.element],
      ["events", word("review.events"), this.events.element],
    ]);
    this.content = this.build();
    this.compare = new Compare(studio, this.element);
    this.compare.closed.on(() => this.library.focus());
    this.library.takeDrops(this.element);
    this.floor.layers.changed.on(() => this.show(this.player.time));
    this.player.changed.on((time) => this.show(time));
    this.player.playingChanged.on((playing) => drawPlay(this.playButton, playing));
    drawPlay(this.playButton, false);
    this.tabs.offer("joints", false);
    this.tabs.shown.on(() => this.askFigures(this.looked.part));
    this.showEmpty();
  }

  shown(): void {
    void this.list();
    this.library.draw();
    const wanted = this.studio.recording;
    this.studio.recording = null;
    if (wanted) void this.open(wanted.path, wanted.time);
  }

  /** Show what is in the folder now. */
  private async list(): Promise<void> {
    await Promise.all([this.studio.refresh(), this.library.load()]).catch((error) => this.studio.toasts.error(error));
    this.library.draw();
    if (!this.looked.recording) this.showEmpty();
  }

  hidden(): void {
    this.player.pause();
    this.compare.pause();
  }

  key(event: KeyboardEvent): boolean {
    if (event.ctrlKey || event.metaKey || event.altKey) return false;
    if (this.compare.active) return this.compare.key(event);
    if (!this.looked.recording) return false;
    const keys: Record<string, () => void> = {
      " ": () => this.player.toggle(),
      ".": () => this.player.step(1),
      ",": () => this.player.step(-1),
      ArrowRight: () => this.player.seek(this.player.time + 1),
      ArrowLeft: () => this.player.seek(this.player.time - 1),
      Home: () => this.player.seek(0),
      End: () => this.player.seek(this.looked.recording?.seconds ?? 0),
      i: () => this.mark(this.looked.fromNow()),
      o: () => this.mark(this.looked.untilNow()),
      Escape: () => this.mark(UNMARKED),
    };
    const act = keys[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!act) return this.floor.key(event);
    event.preventDefault();
    act();
    return true;
  }

  private build(): HTMLElement {
    const bar = this.bar();
    this.pictures.switches.append(this.solids.switch);
    this.stage.arranged.on((large) =>
      this.floor.lendLayers(large.includes("scene") && !large.includes("plan") ? this.solids.menus : null),
    );
    const side = el("aside", { class: "run-side" }, this.tabs.element);
    const rail = el("div", { class: "run-rail", inert: true }, this.pictures.switches, this.stage.rail);
    const chips = chartChips("review.charts", FIRST_CHARTS, this.sheet, () => this.drawCharts());
    const dock = el("div", { class: "run-dock", inert: true }, this.scrub.element);
    const charts = { head: el("div", { class: "run-dock-head" }, this.robot, chips), sheet: this.sheet.element };
    this.stage.element.append(this.empty);
    this.element.append(bar);
    const { tabs, stage } = this;
    return columns(this.element, { side, tabs, stage, large: stage.element, rail, dock, charts });
  }

  private bar(): HTMLElement {
    const bar = el("div", { class: "run-bar", role: "toolbar", "aria-label": word("review.recording"), inert: true });
    const button = (title: string, part: () => Part, text: string, kind = ""): Drawn =>
      html`<button type="button" class=${kind} title=${title} @click=${() => this.mark(part())}>${text}</button>`;
    const speed = (value: string): unknown => (this.player.speed = Number(value));
    const view = html`${this.playButton}<div class="run-group">
          ${iconButton("arrowLeft", word("review.oneTickBack"), () => this.player.step(-1), false, "")}
          ${iconButton("arrowRight", word("review.oneTickOn"), () => this.player.step(1), false, "")}</div>
        <label class="run-figure"><span>${word("review.speed")}</span>${choice(word("review.speed"), SPEEDS, "1", speed)}</label>
        <div class="run-group">
          ${button(word("review.thePartBeginsHereI"), () => this.looked.fromNow(), word("review.markBegin"))}
          ${button(word("review.thePartEndsHereO"), () => this.looked.untilNow(), word("review.markEnd"))}
          ${button(word("review.markNothingEscape"), () => UNMARKED, word("review.clear"), "quiet")}</div>
        <span class="run-spring"></span>${this.title}${this.cut}
        <label class="run-figure"><span>${word("review.time")}</span>${this.time}</label>`;
    draw(bar, view);
    return bar;
  }

  private async open(path: string, time = 0): Promise<void> {
    this.player.pause();
    this.compare.close();
    write(this.title, word("review.opening"));
    // What was chosen last is shown, whichever comes first.
    const turn = ++this.turn;
    try {
      const recording = await recordings.open(path);
      if (turn === this.turn) this.take(recording, time);
    } catch (error) {
      if (turn !== this.turn) return;
      write(this.title, this.looked.recording?.path ?? word("review.noRecording"));
      this.studio.looksAt(this.looked.recording && { path: this.looked.recording.path, time: this.player.time });
      this.studio.toasts.error(error);
    }
  }

  private take(recording: Recording, time: number): void {
    Object.assign(this.looked, { recording, tick: null });
    write(this.title, recording.path);
    this.cut.hidden = recording.whole;
    this.empty.remove();
    this.whole.fill(recording.tracks);
    this.record.clear();
    this.events.fill(recording.events);
    this.scrub.load(recording.seconds, recording.dt, recording.events);
    this.film.load(recording);
    this.joints.show(recording.joints);
    this.tabs.offer("joints", Object.keys(recording.joints).length > 0);
    this.pictures.load(recording);
    this.solids.want(recording, JSON.stringify([recording.scene.bounds, recording.robots.map(({ name }) => name)]));
    this.solids.door.show(recording.scene.items, []);
    this.arrange();
    this.floor.scene(recording.scene.items, recording.scene.bounds);
    this.robot.hidden = recording.robots.length < 2;
    this.library.draw();
    this.element.toggleAttribute("data-open", true);
    for (const part of this.element.querySelectorAll("[inert]")) part.toggleAttribute("inert", false);
    this.choose(recording.robots[0]?.name ?? "");
    this.mark(UNMARKED);
    this.player.load(recording.seconds, recording.dt, time);
    this.numbers.clear();
    void this.plotter.load();
  }

  private arrange(): void {
    if (this.looked.recording) this.stage.show([this.floor.tile, ...this.solids.tiles(), ...this.pictures.tiles()]);
  }

  private choose(robot: string): void {
    this.looked.robot = robot;
    const robots = this.looked.recording?.robots ?? [];
    draw(
      this.robot,
      namesToChoose(
        robots.map(({ name }) => name),
        robot,
      ),
    );
    this.floor.run(robots, robot);
    this.sheet.offer(kindsOf(robots.find(({ name }) => name === robot) ?? null));
    this.plotter.suggest(!robots.some((each) => each.can_drive));
    this.drawCharts();
  }

  private drawCharts(): void {
    this.sheet.show(this.whole.of(this.looked.robot).history);
    this.markCharts();
  }

  private markCharts(): void {
    const marks = this.marks();
    this.sheet.mark(marks);
    this.plotter.mark(marks);
  }

  private marks(): Marks {
    const { recording, time, part, events } = this.looked;
    return { now: recording ? time : null, ...part, events };
  }

  private show(time: number): void {
    const { recording } = this.looked;
    if (!recording) return;
    write(this.time, word("review.timeOf", { time: clock(time), whole: clock(recording.seconds) }));
    this.studio.looksAt({ path: recording.path, time });
    this.scrub.show(time);
    this.markCharts();
    this.showFloor(recording, time);
    this.askTick(time);
    this.pictures.show();
    this.solids.door.poses(() => recordings.poses(this.looked.recording?.path ?? "", time));
  }

  /** Draw robots where the tracks have them, with what the last tick that came had seen. */
  private showFloor(recording: Recording, time: number): void {
    const robots: Record<string, RobotTick> = {};
    for (const [name, track] of Object.entries(recording.tracks)) {
      const k = rowAt(track.time, time + 1e-6);
      const [truth, estimate, odometry] = [track.truth[k], track.estimate[k], track.odometry[k]];
      if (!truth || !estimate || !odometry) continue;
      const known = this.looked.tick?.robots[name];
      const close = known && Math.abs((this.looked.tick?.time ?? 0) - time) < 0.5 * recording.dt;
      robots[name] = close ? known : { ...(known ?? NOTHING), sightings: [], truth, estimate, odometry };
      const { trails } = this.record.of(name);
      trails.truth.until(track.truth, track.time, k + 1);
      trails.estimate.until(track.estimate, track.time, k + 1);
      trails.odometry.until(track.odometry, track.time, k + 1);
    }
    const { things = {}, people = {}, bodies = {}, removed = [] } = this.looked.tick ?? {};
    const moment = { time, robots, things, people, bodies, removed };
    this.floor.show(moment);
    this.joints.tick(this.looked.tick?.joints);
    this.solids.door.think(this.floor.thoughts(moment));
  }

  private async fetchTick(time: number): Promise<void> {
    const { recording } = this.looked;
    if (!recording) return;
    try {
      const tick = await recordings.tick(recording.path, time);
      if (this.looked.recording !== recording) return;
      this.looked.tick = tick;
      this.pictures.recognise();
      this.showFloor(recording, this.player.time);
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
    }
  }

  private mark(part: Part): void {
    this.looked.part = part;
    this.scrub.mark(part);
    this.markCharts();
    this.film.mark();
    this.figured = false;
    const isPart = part.from !== null && part.to !== null;
    if (isPart) this.tabs.show("figures");
    this.table.wait();
    if (isPart || this.looked.isWhole) this.askFigures(part);
    else this.table.ask();
  }

  private async fetchFigures(part: Part): Promise<void> {
    const { from, to } = part;
    const { recording } = this.looked;
    // What nobody sees costs nothing.
    if (!recording || !this.tabs.isShown("figures") || this.figured) return;
    const isWanted = (): boolean => this.looked.recording === recording && this.looked.part === part;
    try {
      const figures = await recordings.statistics(recording.path, from, to);
      if (isWanted()) this.table.show(figures, from, to);
      this.figured ||= isWanted();
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      if (isWanted()) this.table.fail(error.message);
    }
  }

  private showEmpty(): void {
    const some = this.studio.folder.recordings.length > 0;
    const hint = some ? word("review.chooseOneOnTheLeft") : word("review.recordARunFirstOr");
    const run = html`<button type="button" class="primary" @click=${() => this.studio.show("run")}
      >${word("review.goToRun")}</button>`;
    const view = html`<h2>${word("review.noRecordingIsOpen")}</h2><p class="hint">${hint}</p>${some ? nothing : run}`;
    draw(this.empty, view);
    this.content.querySelector(".run-stage")?.append(this.empty);
  }
}
