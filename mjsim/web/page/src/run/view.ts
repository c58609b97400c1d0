/** All that is seen of a run, and what is done to it. */

import { getBytes } from "../api";
import { chartChips } from "../charts/chips";
import { Plotter } from "../charts/plotter";
import { type Kind, kindsOf, Sheet } from "../charts/sheet";
import { SolidsTile } from "../scene/tile";
import type { Studio, View } from "../shell/view";
import { columns } from "../ui/columns";
import { el } from "../ui/dom";
import { throttled } from "../ui/signal";
import { Tabs } from "../ui/tabs";
import { Stage } from "../ui/tile";
import { draw, namesToChoose } from "../ui/view";
import { said, word } from "../words/words";
import { Advice, canMove } from "./advice";
import { Banner } from "./banner";
import { Bar } from "./bar";
import { Cameras } from "./cameras";
import { Current } from "./current";
import { EventList, sentenceOf } from "./events";
import { Floor } from "./floor";
import { explainJoints, JointPanel } from "./joints";
import { type Push, Wheel } from "./keys";
import { Link, type LinkState } from "./link";
import { NoisePanel } from "./noise";
import { Pad } from "./pad";
import type { EventNews, News, RefusedNews, RunNews, RunRequest, TickNews } from "./protocol";
import { RunRecord } from "./record";
import { Setup } from "./setup";
import { sideSwitch } from "./side";
import { startWorld } from "./start";
import { Keep, leaderOf, type TouchAnswer } from "./touch_keep";

/** Charts are drawn at most this often [ms]. */
const CALM = 120;
const FIRST_CHARTS: Kind[] = ["x", "y", "heading", "nees", "timing"];

export class RunView implements View {
  readonly element = el("section", { class: "view run", "aria-label": word("run.run") });
  private readonly record = new RunRecord();
  private readonly leader = leaderOf({
    isLive: () => this.current.run?.state === "running",
    send: (touch) => this.send(touch),
    told: () => ({ touch: this.floor.touch, hands: this.newest?.hands ?? {}, toasts: this.studio.toasts }),
  });
  private readonly floor: Floor = new Floor(this.record, this.leader);
  private readonly stage = new Stage("run.stage");
  private readonly sheet: Sheet;
  private readonly plotter: Plotter;
  private readonly bar: Bar;
  private readonly setup: Setup;
  private readonly noise = new NoisePanel((key, value) => this.send({ do: "set", key, value }));
  private readonly tabs: Tabs;
  private readonly joints = new JointPanel(this.leader);
  private readonly events = new EventList(word("run.whatHappensToRobotsAnd"));
  private readonly keep: Keep;
  private readonly wheel = new Wheel(
    () => this.canDrive(),
    (push) => this.drive(push),
  );
  private readonly pad = new Pad(this.wheel);
  private readonly cameras = new Cameras(
    (request) => void this.link?.send(request),
    () => this.arrange(),
    () => this.visible && this.solids.door.isReady,
  );
  private readonly solids: SolidsTile = new SolidsTile(
    "run.scene",
    () => getBytes("/api/run/scene"),
    () => this.arrange(),
    { yields: true },
  );
  private readonly banner = new Banner();
  private readonly advice = new Advice({
    open: () => void this.studio.askOpen(),
    make: () => void this.studio.askNew(),
    edit: () => this.studio.show("edit"),
    review: (recording) => this.studio.show("review", recording),
  });
  private readonly noPictures = el("p", { class: "hint run-empty" }, word("run.picturesOfTheCamerasCome"));
  private readonly robot = el("select", {
    "aria-label": word("run.robot"),
    hidden: true,
    onchange: () => this.chooseRobot(this.robot.value),
  });
  /** Whether this page shows one run alone, which was begun elsewhere. */
  private readonly live: boolean;
  private readonly current: Current;
  private link: Link | null = null;
  private newest: TickNews | null = null;
  private visible = false;
  /** The text of the run that was asked for last. */
  private begun = "";
  private drawing = 0;
  private readonly chartsSoon = throttled(() => this.drawCharts(), CALM);

  constructor(private readonly studio: Studio) {
    this.live = studio.folder.mode === "live";
    this.current = new Current(this.live, studio.document);
    const orders = {
      start: () => void this.start(),
      pause: () => this.send({ do: "pause" }),
      go: () => this.send({ do: "go" }),
      tick: () => this.send({ do: "tick" }),
      restart: () => this.send({ do: "restart" }),
      stop: () => this.send({ do: "stop" }),
      speed: (value: number | null) => this.current.isOn && this.send({ do: "speed", value }),
    };
    this.bar = new Bar(orders, !this.live);
    this.sheet = new Sheet(FIRST_CHARTS, {}, "run");
    this.plotter = new Plotter(this.sheet.element, "run", this.record.numbers, {}, (error) =>
      studio.toasts.error(error),
    );
    this.setup = new Setup(studio);
    this.keep = new Keep(studio, this.events.element);
    const setup: [string, string, HTMLElement][] = this.live ? [] : [["setup", word("run.setup"), this.setup.element]];
    this.tabs = new Tabs("run.tab", [
      ...setup,
      ["noise", word("run.noise"), this.noise.element],
      ["arms", word("run.joints"), this.joints.element],
      ["plot", word("run.plot"), this.plotter.element],
      ["events", word("run.events"), this.keep.element],
    ]);
    this.build();
    this.arrange();
    studio.document.parsedChanged.on(() => this.visible && this.takeWorld());
    studio.document.opened.on(() => this.leave());
    this.floor.layers.changed.on(() => this.soon());
    window.setInterval(() => this.visible && this.bar.rate(this.cameras.rate()), 500);
  }

  shown(): void {
    this.visible = true;
    if (!this.link) this.connect();
    this.cameras.watch();
    this.takeWorld();
    this.soon();
  }

  hidden(): void {
    this.visible = false;
    this.wheel.releaseAll();
    // What nobody sees need not be drawn.
    this.send({ do: "watch", cameras: [] });
  }

  key(event: KeyboardEvent): boolean {
    if (this.floor.touch.key(event) || this.wheel.down(event)) return true;
    if (event.key === " ") this.bar.press();
    else if (event.key === "." && this.current.run?.state === "paused") this.send({ do: "tick" });
    else return this.floor.key(event);
    return true;
  }

  private build(): void {
    const side = el("aside", { class: "run-side" }, this.tabs.element);
    const chips = chartChips("run.charts", FIRST_CHARTS, this.sheet, () => this.soon());
    this.floor.host.append(this.pad.element);
    this.cameras.switches.append(this.solids.switch);
    this.solids.door.ready.on(() => this.cameras.watch());
    this.stage.arranged.on((large) =>
      this.floor.lendLayers(large.includes("scene") && !large.includes("plan") ? this.solids.menus : null),
    );
    this.floor.touch.leadIn(this.solids.door);
    this.floor.tools.aimIn(this.solids.door);
    this.solids.door.chosen.on((item) => item?.kind === "robot" && this.chooseRobot(item.name ?? ""));
    this.floor.touch.missed.on((names) => explainJoints(names, this.current.run, this.studio.toasts));
    this.bar.element.prepend(sideSwitch(side));
    const dock = el("div", { class: "run-dock" });
    const charts = { head: el("div", { class: "run-dock-head" }, this.robot, chips), sheet: this.sheet.element };
    const rail = el("div", { class: "run-rail" }, this.cameras.switches, this.noPictures, this.stage.rail);
    const middle = el("div", { class: "run-middle" }, this.stage.element, this.advice.element);
    this.element.append(this.bar.element, this.banner.element);
    const { tabs, stage } = this;
    columns(this.element, { side, tabs, stage, large: middle, rail, dock, charts });
  }

  private arrange(): void {
    const pictures = this.cameras.tiles();
    this.noPictures.hidden = pictures.length > 0;
    this.stage.show([this.floor.tile, ...this.solids.tiles(), ...pictures]);
  }

  private connect(): void {
    this.link = new Link({
      state: (state) => this.connection(state),
      news: (news) => this.take(news),
      picture: (head, jpeg) => this.cameras.show(head, jpeg),
      bodies: ({ number }, places) => {
        this.solids.door.poses(() => Promise.resolve(places));
        this.send({ do: "shown", number });
      },
    });
  }

  private connection(state: LinkState): void {
    // A page of one run is over with it; a studio is wanted back.
    const lost = state === "lost" || (state === "closed" && !this.live);
    this.bar.connection(lost ? "lost" : state);
    this.banner.connection(state, lost);
    if (state === "open" && this.visible) {
      this.cameras.watch();
      if (!this.live) this.setup.world(); // what was asked of a server that had gone is asked again
    }
    if (state === "open") return;
    this.wheel.releaseAll();
    this.leader.forget();
  }

  private send(request: RunRequest): void {
    this.link?.send(request);
  }

  private take(news: News): void {
    if (news.kind === "run") this.takeRun(this.current.own(news));
    else if (news.kind === "touched" || news.kind === "short") this.leader.answered(news);
    else if (news.kind === "refused") void this.refused(news);
    else if (this.live || this.current.run?.state !== "idle") this.takeMoment(news);
  }

  private takeMoment(news: Exclude<News, RunNews | RefusedNews | TouchAnswer>): void {
    if (news.kind === "tick") this.takeTick(news);
    else if (news.kind === "event") this.takeEvent(news);
    else if (news.kind === "scene") {
      this.floor.scene(news.items, news.bounds);
      this.cameras.scene(news.bounds);
      this.solids.want(news, this.current.run?.path ?? this.current.run?.name ?? "");
      this.solids.door.show(news.items, []);
    } else {
      this.record.fill(news.robots);
      this.events.fill(news.events);
      this.soon();
    }
  }

  private takeEvent(news: EventNews): void {
    this.events.add(news);
    this.current.event(news);
  }

  /** Another world was opened: what is over of the one before is no longer shown. */
  private leave(): void {
    this.current.leave();
    if (this.current.run) this.takeRun(this.current.own(this.current.run));
  }

  private takeRun(news: RunNews): void {
    const before = this.current.run?.state;
    const another = this.current.isAnother(news);
    this.current.run = news;
    if (another || (news.state === "idle" && before !== "idle")) this.forget();
    if (news.state === "idle" && before !== "idle") this.takeWorld();
    this.bar.run(news);
    this.offerRobots(news);
    this.cameras.run(news.robots, news.state !== "idle");
    this.noise.show(news.noise ?? [], this.current.isControllable);
    this.tabs.offer("noise", news.state === "idle" || (news.noise ?? []).length > 0);
    this.banner.run(news.state === "failed" && news.error ? said(news.error) : null);
    this.keep.show(news);
    this.floor.touch.enable(this.current.isControllable);
    this.element.dataset["state"] = news.state;
  }

  private takeTick(news: TickNews): void {
    if (this.newest && news.time < this.newest.time) this.forget();
    this.newest = news;
    this.record.add(news);
    this.soon();
  }

  private forget(): void {
    this.record.clear();
    this.events.clear();
    this.newest = null;
    this.current.forgetEvents();
    this.floor.clear();
    this.cameras.clear();
  }

  /** Draw with the next frame of the screen, once. */
  private soon(): void {
    if (this.drawing || !this.visible) return;
    this.drawing = requestAnimationFrame(() => {
      this.drawing = 0;
      this.draw();
    });
  }

  private draw(): void {
    if (this.newest) {
      this.bar.tick(this.newest);
      this.floor.show(this.newest);
      this.solids.door.think(this.floor.thoughts(this.newest));
      this.joints.tick(this.newest, this.current.chosen);
      this.advise();
    }
    this.chartsSoon();
  }

  private drawCharts(): void {
    if (!this.visible) return;
    this.sheet.show(this.record.of(this.current.chosen).history);
    void this.plotter.refresh();
  }

  /** Take up the robots of the world that is open, for the setup. */
  private takeWorld(): void {
    const { parsed, items } = this.studio.document;
    this.bar.offer(!this.live && this.studio.document.isOpen);
    this.advise();
    if (!this.live) this.setup.world();
    if (this.current.run && this.current.run.state !== "idle") return;
    this.floor.scene(items, parsed.bounds);
    this.floor.showRobots(true);
  }

  private start(): Promise<void> {
    return startWorld(this.studio, async (path, own) => {
      const text = (this.begun = await this.setup.put(path, own));
      this.banner.clear();
      this.send({ do: "start", path, text, speed: this.bar.speed, ...this.setup.recording() });
    }).catch((error: unknown) => this.studio.toasts.error(error));
  }

  /** Say why a request was refused; one that waits for trust is given again once it is there. */
  private async refused(news: RefusedNews): Promise<void> {
    if (news.do === "start" && news.needs_trust) {
      if (await this.studio.askTrust({ code: news.needs_trust, text: this.begun })) await this.start();
      return;
    }
    if (news.do === "touch") this.leader.answered(news);
    else this.studio.toasts.error(said(news.error));
  }

  private offerRobots(news: RunNews): void {
    this.plotter.suggest(!news.robots.some((robot) => robot.can_drive));
    this.robot.hidden = news.robots.length < 2;
    this.chooseRobot(this.current.robot?.name ?? news.robots[0]?.name ?? "");
    this.floor.showRobots(news.state === "idle");
  }

  private chooseRobot(name: string): void {
    this.wheel.releaseAll();
    this.current.chosen = name;
    const { run, robot, driven } = this.current;
    const names = (run?.robots ?? []).map((each) => each.name);
    draw(this.robot, namesToChoose(names, name));
    this.pad.canStrafe(robot?.can_strafe ?? false);
    this.sheet.offer(kindsOf(robot));
    const navigator = run?.drivers?.[name]?.navigator ?? null;
    this.pad.show(this.canDrive(), navigator, driven);
    this.floor.tools.offer(navigator !== null && this.canDrive() ? name : null);
    this.floor.run(run?.robots ?? [], name, run?.joints);
    this.showArms();
    this.advise();
    this.soon();
  }

  /** Offer the arms of the robot that is chosen, and the mechanisms. */
  private showArms(): void {
    const { run, robot } = this.current;
    // A page of one arm alone is there to move it.
    if (this.live && robot?.arms.length && run?.robots.length === 1 && !this.joints.hasArms) this.tabs.show("arms");
    this.joints.show(run, this.current.chosen, this.current.isControllable);
    this.tabs.offer("arms", Object.keys(run?.joints ?? {}).length > 0);
  }

  private canDrive(): boolean {
    return this.visible && this.current.canDrive;
  }

  private drive(push: Push | null): void {
    if (push) this.pad.element.hidden = !(this.current.driven = true);
    this.advise();
    this.send({ do: "drive", robot: this.current.chosen, ...(push ?? { forward: null, left: null, turn: null }) });
  }

  private advise(): void {
    const { path, items, parsed } = this.studio.document;
    const isBroken = parsed.problems.some(({ kind }) => kind === "error");
    const world = path === null ? null : { path, isBroken, hasMotion: items.some(canMove) };
    const { run, chosen: robot, driven, other } = this.current;
    const held = this.current.heldUp(this.newest?.time ?? 0);
    this.advice.show({ run, world, live: this.live, robot, holdUp: held ? sentenceOf(held) : "", driven, other });
  }
}
