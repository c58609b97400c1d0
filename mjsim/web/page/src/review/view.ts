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
import type { RobotTick, TickNews } from "../run/protocol";
import { RunRecord } from "../run/record";
import { SolidsTile } from "../scene/tile";
import type { Studio, View } from "../shell/view";
import { columns } from "../ui/columns";
import { button, choice, write } from "../ui/controls";
import { el, fill } from "../ui/dom";
import { icon } from "../ui/icons";
import { newestWins } from "../ui/signal";
import { Tabs } from "../ui/tabs";
import { Stage } from "../ui/tile";
import { word } from "../words/words";
import { Compare } from "./compare";
import { Film } from "./film";
import { Library } from "./library";
import { RecordedNumbers } from "./numbers";
import { Pictures } from "./pictures";
import { Player } from "./player";
import { NOTHING, type Recording, recordings } from "./recording";
import { type Part, Scrub } from "./scrub";
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
  private readonly player = new Player();
  private readonly record = new RunRecord();
  private readonly whole = new RunRecord();
  private readonly floor = new Floor(this.record);
  private readonly stage = new Stage("review.stage");
  private readonly pictures = new Pictures(() => this.arrange());
  private readonly solids = new SolidsTile(
    "review.scene",
    () => recordings.scene(this.recording?.path ?? ""),
    () => this.arrange(),
  );
  private readonly scrub = new Scrub((time) => this.player.seek(time));
  private readonly film = new Film();
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
  private readonly numbers = new RecordedNumbers();
  private readonly robot = el("select", {
    "aria-label": word("review.robot"),
    hidden: true,
    onchange: () => this.choose(this.robot.value),
  });
  private readonly playButton = button(
    { class: "primary run-main", title: word("review.playSpace") },
    () => this.player.toggle(),
    icon("play"),
    word("review.play"),
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
  private recording: Recording | null = null;
  private chosen = "";
  private part: Part = { from: null, to: null };
  private tick: TickNews | null = null;
  /** Whether the figures of the part are there. */
  private figured = false;
  /** When something happened [s]. */
  private eventTimes: number[] = [];
  /** How many recordings have been asked for. */
  private turn = 0;
  private readonly askTick = newestWins((time: number) => this.fetchTick(time));
  private readonly askFigures = newestWins((part: Part) => this.fetchFigures(part));

  constructor(private readonly studio: Studio) {
    this.table = new Table((text) => this.studio.toasts.done(text));
    this.library = new Library(
      studio,
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
    this.player.playingChanged.on((playing) =>
      fill(this.playButton, icon(playing ? "pause" : "play"), playing ? word("review.pause") : word("review.play")),
    );
    this.tabs.offer("joints", false);
    this.tabs.shown.on(() => this.askFigures(this.part));
    this.showEmpty();
  }

  shown(): void {
    void this.list();
    this.library.show(this.recording?.path ?? null);
    const wanted = this.studio.recording;
    this.studio.recording = null;
    if (wanted) void this.open(wanted.path, wanted.time);
  }

  /** Show what is in the folder now. */
  private async list(): Promise<void> {
    await Promise.all([this.studio.refresh(), this.library.load()]).catch((error) => this.studio.toasts.error(error));
    this.library.show(this.recording?.path ?? null);
    if (!this.recording) this.showEmpty();
  }

  hidden(): void {
    this.player.pause();
    this.compare.pause();
  }

  key(event: KeyboardEvent): boolean {
    if (event.ctrlKey || event.metaKey || event.altKey) return false;
    if (this.compare.active) return this.compare.key(event);
    if (!this.recording) return false;
    const keys: Record<string, () => void> = {
      " ": () => this.player.toggle(),
      ".": () => this.player.step(1),
      ",": () => this.player.step(-1),
      ArrowRight: () => this.player.seek(this.player.time + 1),
      ArrowLeft: () => this.player.seek(this.player.time - 1),
      Home: () => this.player.seek(0),
      End: () => this.player.seek(this.recording?.seconds ?? 0),
      i: () => this.markFrom(),
      o: () => this.markTo(),
      Escape: () => this.mark({ from: null, to: null }),
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
    const dock = el(
      "div",
      { class: "run-dock", inert: true },
      this.scrub.element,
      el("div", { class: "run-dock-head" }, this.robot, chips),
      this.sheet.element,
    );
    this.stage.element.append(this.empty);
    this.element.append(bar);
    return columns(this.element, { side, large: this.stage.element, rail, dock });
  }

  private bar(): HTMLElement {
    const speeds = choice(
      { "aria-label": word("review.speed") },
      SPEEDS,
      "1",
      (value) => (this.player.speed = Number(value)),
    );
    return el(
      "div",
      { class: "run-bar", role: "toolbar", "aria-label": word("review.recording"), inert: true },
      this.playButton,
      el(
        "div",
        { class: "run-group" },
        button({ class: "square", title: word("review.oneTickBack") }, () => this.player.step(-1), icon("arrowLeft")),
        button({ class: "square", title: word("review.oneTickOn") }, () => this.player.step(1), icon("arrowRight")),
      ),
      el("label", { class: "run-figure" }, el("span", {}, word("review.speed")), speeds),
      el(
        "div",
        { class: "run-group" },
        button({ title: word("review.thePartBeginsHereI") }, () => this.markFrom(), word("review.markBegin")),
        button({ title: word("review.thePartEndsHereO") }, () => this.markTo(), word("review.markEnd")),
        button(
          { class: "quiet", title: word("review.markNothingEscape") },
          () => this.mark({ from: null, to: null }),
          word("review.clear"),
        ),
      ),
      el("span", { class: "run-spring" }),
      this.title,
      this.cut,
      el("label", { class: "run-figure" }, el("span", {}, word("review.time")), this.time),
    );
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
      write(this.title, this.recording?.path ?? word("review.noRecording"));
      this.studio.looksAt(this.recording && { path: this.recording.path, time: this.player.time });
      this.studio.toasts.error(error);
    }
  }

  private take(recording: Recording, time: number): void {
    this.recording = recording;
    this.tick = null;
    this.eventTimes = recording.events.map((event) => event.time);
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
    fill(this.robot, ...recording.robots.map(({ name }) => el("option", { value: name }, name)));
    this.robot.hidden = recording.robots.length < 2;
    this.library.show(recording.path);
    this.element.toggleAttribute("data-open", true);
    for (const part of this.element.querySelectorAll("[inert]")) part.toggleAttribute("inert", false);
    this.choose(recording.robots[0]?.name ?? "");
    this.mark({ from: null, to: null });
    this.player.load(recording.seconds, recording.dt, time);
    this.numbers.open(recording.path);
    void this.plotter.load();
  }

  private arrange(): void {
    if (this.recording) this.stage.show([this.floor.tile, ...this.solids.tiles(), ...this.pictures.tiles()]);
  }

  private choose(robot: string): void {
    this.chosen = robot;
    this.robot.value = robot;
    this.floor.run(this.recording?.robots ?? [], robot);
    this.sheet.offer(kindsOf(this.recording?.robots.find(({ name }) => name === robot) ?? null));
    this.plotter.suggest(!this.recording?.robots.some((each) => each.can_drive));
    this.drawCharts();
  }

  private drawCharts(): void {
    this.sheet.show(this.whole.of(this.chosen).history);
    this.markCharts();
  }

  private markCharts(): void {
    const marks = this.marks();
    this.sheet.mark(marks);
    this.plotter.mark(marks);
  }

  private marks(): Marks {
    return { now: this.recording ? this.player.time : null, ...this.part, events: this.eventTimes };
  }

  private show(time: number): void {
    const recording = this.recording;
    if (!recording) return;
    write(this.time, word("review.timeOf", { time: clock(time), whole: clock(recording.seconds) }));
    this.studio.looksAt({ path: recording.path, time });
    this.scrub.show(time);
    this.markCharts();
    this.showFloor(recording, time);
    this.askTick(time);
    this.pictures.show(time);
    this.solids.door.poses(() => recordings.poses(this.recording?.path ?? "", time));
  }

  /** Draw robots where the tracks have them, with what the last tick that came had seen. */
  private showFloor(recording: Recording, time: number): void {
    const robots: Record<string, RobotTick> = {};
    for (const [name, track] of Object.entries(recording.tracks)) {
      const k = rowAt(track.time, time + 1e-6);
      const [truth, estimate, odometry] = [track.truth[k], track.estimate[k], track.odometry[k]];
      if (!truth || !estimate || !odometry) continue;
      const known = this.tick?.robots[name];
      const close = known && Math.abs((this.tick?.time ?? 0) - time) < 0.5 * recording.dt;
      robots[name] = close ? known : { ...(known ?? NOTHING), sightings: [], truth, estimate, odometry };
      const { trails } = this.record.of(name);
      trails.truth.until(track.truth, track.time, k + 1);
      trails.estimate.until(track.estimate, track.time, k + 1);
      trails.odometry.until(track.odometry, track.time, k + 1);
    }
    const { things = {}, people = {}, bodies = {}, removed = [] } = this.tick ?? {};
    const moment = { time, robots, things, people, bodies, removed };
    this.floor.show(moment);
    this.joints.tick(this.tick?.joints);
    this.solids.door.think(this.floor.thoughts(moment));
  }

  private async fetchTick(time: number): Promise<void> {
    const recording = this.recording;
    if (!recording) return;
    try {
      const tick = await recordings.tick(recording.path, time);
      if (this.recording !== recording) return;
      this.tick = tick;
      this.pictures.recognise(tick);
      this.showFloor(recording, this.player.time);
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
    }
  }

  private markFrom(): void {
    const { time } = this.player;
    this.mark({ from: time, to: this.part.to !== null && this.part.to > time ? this.part.to : null });
  }

  private markTo(): void {
    const { time } = this.player;
    this.mark({ from: this.part.from !== null && this.part.from < time ? this.part.from : null, to: time });
  }

  private mark(part: Part): void {
    this.part = part;
    this.scrub.mark(part);
    this.markCharts();
    const { from, to } = part;
    const whole = from === null && to === null;
    this.film.mark(from ?? 0, to ?? this.recording?.seconds ?? 0, !whole);
    this.figured = false;
    const isPart = from !== null && to !== null;
    if (isPart) this.tabs.show("figures");
    this.table.wait();
    if (isPart || whole) this.askFigures({ from, to });
    else this.table.ask();
  }

  private async fetchFigures({ from, to }: Part): Promise<void> {
    const recording = this.recording;
    // What nobody sees costs nothing.
    if (!recording || this.tabs.now !== "figures" || this.figured) return;
    const isWanted = (): boolean => this.recording === recording && this.part.from === from && this.part.to === to;
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
    const run = button({ class: "primary" }, () => this.studio.show("run"), word("review.goToRun"));
    fill(
      this.empty,
      el("h2", {}, word("review.noRecordingIsOpen")),
      el("p", { class: "hint" }, hint),
      some ? null : run,
    );
    this.content.querySelector(".run-stage")?.append(this.empty);
  }
}
