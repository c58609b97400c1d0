/** The modules that can be chosen for a robot: what there is, asked of the server once for a world, and the choice. */

import type { Item, Module, Modules, Path } from "../api";
import type { Studio } from "../shell/view";
import { Signal } from "../ui/signal";
import { html, type View } from "../ui/view";
import { meaningOf, word } from "../words/words";
import { choose, type Entry } from "./gallery";
import { allOf, begun, fits, isShipped, offersFor, type Role, readingsOf, robotAt, roleOf } from "./offers";
import type { SchemaBook } from "./schema";

const PARTS = { arms: "panel.anArm", balancing: "panel.aBalancingBase", max_left: "panel.aDriveSideways" } as const;
const NONE = "none";
/** The avoidance that mjsim brings along. */
const BUILT_IN = "built-in";
const WITHOUT: Record<Role, string> = {
  observer: word("panel.withoutObserver"),
  estimator: word("panel.withoutEstimator"),
  navigator: word("panel.withoutNavigator"),
  avoidance: word("panel.withoutAvoidance"),
  controller: word("panel.withoutController"),
};
const TITLES: Record<Role, string> = {
  observer: word("panel.chooseAnObserver"),
  estimator: word("panel.chooseAnEstimator"),
  navigator: word("panel.chooseANavigator"),
  avoidance: word("panel.chooseAnAvoidance"),
  controller: word("panel.chooseAController"),
};

export class ModuleShelf {
  /** There are others now. */
  readonly changed = new Signal();
  private modules: Modules | null = null;
  private asked: string | null = null;
  private answer: Promise<void> = Promise.resolve();

  constructor(
    private readonly studio: Studio,
    private readonly book: SchemaBook,
  ) {}

  /** What there is; null until the server has told. */
  get all(): Modules | null {
    void this.ask();
    return this.modules;
  }

  find(use: string): ReturnType<typeof allOf>[number] | undefined {
    return this.all ? allOf(this.all).find((module) => module.use === use) : undefined;
  }

  /** Let the person choose for a key of the world file. */
  async choose(path: Path): Promise<{ value: unknown } | null> {
    const { visits } = this.studio;
    if (this.modules) this.asked = null; // files may have come meanwhile
    await this.ask();
    if (!this.modules || this.studio.visits !== visits) return null;
    const robot = robotAt(path, this.studio.document.items);
    const role = roleOf(String(path.at(-1)));
    const chosen = await choose(TITLES[role], () => null, groupsFor(role, robot, this.modules), otherUse);
    if (chosen === null) return null;
    if (chosen === NONE || chosen === BUILT_IN) return { value: chosen === BUILT_IN ? true : undefined };
    const module = this.find(chosen);
    return { value: module ? begun(module, robot, this.book) : { use: chosen } };
  }

  /** Ask for the modules beside the world; those of an earlier world may come late, and are none of this. */
  private ask(): Promise<void> {
    const { path, needsName } = this.studio.document;
    const wanted = needsName ? "" : (path ?? "");
    if (wanted !== this.asked) this.answer = this.read((this.asked = wanted));
    return this.answer;
  }

  private async read(wanted: string): Promise<void> {
    try {
      const modules = await this.studio.api.modules(wanted || null);
      if (this.asked !== wanted) return;
      this.modules = modules;
      this.changed.emit();
    } catch (error) {
      if (this.asked === wanted) this.studio.toasts.error(error);
    }
  }
}

/** What can be chosen for a role: what fits the robot first. */
function groupsFor(role: Role, robot: Item | null, modules: Modules): [string, Entry[]][] {
  const given = readingsOf(robot, modules);
  const offers = offersFor(modules, role);
  const some = (of: (fit: boolean, shipped: boolean) => boolean): Entry[] =>
    offers
      .filter((offer) => of(!robot || fits(offer, given), isShipped(offer)))
      .map((offer) => {
        const fault =
          modules.faults[offer.use.split(":")[0] ?? ""] ?? (robot && !fits(offer, given) ? lackOf(offer) : null);
        return { value: offer.use, name: offer.title, about: meaningOf(offer.about), ...(fault ? { fault } : {}) };
      });
  const listed = new Set(allOf(modules).map(({ use }) => use.split(":")[0]));
  const broken = Object.entries(modules.faults).filter(([file]) => !listed.has(file));
  const programs = modules.programs.map((use) => ({ value: use, name: use.slice("exec:".length), about: "" }));
  return [
    [word(robot ? "panel.fitsThisRobot" : "panel.comeWithMjsim"), some((fit, shipped) => fit && shipped)],
    [
      word("panel.inThisFolder"),
      [
        ...some((_, shipped) => !shipped),
        ...broken.map(([file, fault]) => ({ value: file, name: file, about: "", fault })),
      ],
    ],
    [word("panel.programsInThisFolder"), programs],
    [word("panel.without"), withoutModule(role)],
    [word("panel.needsOtherSensors"), some((fit, shipped) => !fit && shipped)],
  ];
}

function lackOf({ needs, parts }: Module): string {
  return word("panel.needsReadings", { readings: [...needs, ...parts.map((part) => word(PARTS[part]))].join(", ") });
}

function withoutModule(role: Role): Entry[] {
  const none = { value: NONE, name: word("panel.noModule"), about: WITHOUT[role] };
  return role === "avoidance"
    ? [{ value: BUILT_IN, name: word("panel.builtIn"), about: word("panel.slowsDownBefore") }, none]
    : [none];
}

/** For what is in no list: a class, a function or a program by its name. */
function otherUse(answer: (value: string) => void): View {
  const label = word("panel.anotherModule");
  const give = ({ currentTarget }: Event): void => {
    const input = (currentTarget as Element).parentElement?.querySelector("input");
    if (input?.value.trim()) answer(input.value.trim());
    else input?.focus();
  };
  return html`<p class="list-title">${label}</p><div class="joined"><input class="mono" aria-label=${label}
    placeholder="my_slam.py:MySlam, my_slam.m, exec:./my_slam --flag" spellcheck="false" autocomplete="off"
    @keydown=${(event: KeyboardEvent) => event.key === "Enter" && give(event)}><button type="button" @click=${give}
    >${word("panel.use")}</button></div>`;
}
