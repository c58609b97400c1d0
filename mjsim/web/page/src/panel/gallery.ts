/** Choosing one of many by its picture: models, robots and arms, with a search. */

import type { Studio } from "../shell/view";
import { askWith } from "../ui/dialog";
import { el } from "../ui/dom";
import { sign } from "../ui/icons";
import { draw, html, nothing, type View, withValue } from "../ui/view";
import { meaningOf, word } from "../words/words";

/** What can be chosen. */
export interface Entry {
  /** As the world's text has it. */
  value: string;
  name: string;
  about: string;
  /** What speaks against it. */
  fault?: string;
  /** What is known of it only later. */
  later?: Promise<Known | null>;
}

type Known = Pick<Entry, "about" | "fault">;

/** The picture of an entry; null where there is none. */
type Portrait = (entry: Entry) => View;

type Kind = "model" | "robot" | "arm";

/** Let the person choose a model; null when they would rather not. */
export async function chooseModel(studio: Studio): Promise<string | null> {
  await studio.refresh(); // models may have come into the folder meanwhile
  const { models, shipped } = studio.folder;
  return choose(word("panel.chooseAModel"), portrait(studio, "model"), [
    [word("panel.inThisFolder"), ownFiles(studio, models).map(modelEntry)],
    [word("panel.comeWithMjsim"), shipped.models.map(modelEntry)],
  ]);
}

/** Files of the folder as the world that is open names them: beside it or below. */
export function ownFiles({ document }: Studio, files: string[]): string[] {
  const base = (document.path ?? "").replace(/^shipped:.*$/, "").replace(/[^/]*$/, "");
  return files.filter((path) => path.startsWith(base)).map((path) => path.slice(base.length));
}

/** The name of a file without its folder. */
export function nameOf(path: string): string {
  return path.replace(/^.*\//, "");
}

/** Let the person choose a preset of a robot, or a file that becomes one; null when they would rather not. */
export async function chooseRobot(studio: Studio): Promise<string | null> {
  await studio.refresh();
  const entries = studio.folder.shipped.presets.map(({ name, about }) => ({
    value: name,
    name,
    about: meaningOf(about),
  }));
  const [preset, model] = [portrait(studio, "robot"), portrait(studio, "model")];
  const chosen = await choose(
    word("panel.chooseARobot"),
    (entry) => (isRobotFile(entry.value) ? model : preset)(entry),
    [
      [word("panel.inThisFolder"), ownFiles(studio, studio.folder.robots).map(modelEntry)],
      [word("panel.comeWithMjsim"), entries],
    ],
  );
  return chosen && isRobotFile(chosen) ? madePreset(studio, chosen) : chosen;
}

function isRobotFile(path: string): boolean {
  return /\.(urdf|xacro)$/i.test(path);
}

/** The preset of a robot's file, made beside the world. */
async function madePreset(studio: Studio, file: string): Promise<string | null> {
  try {
    studio.toasts.done(word("panel.presetIsBeingMade", { file }));
    const { path } = await studio.api.robot(file, studio.document.path);
    studio.toasts.done(word("panel.presetMade", { path, file }));
    return path;
  } catch (error) {
    studio.toasts.error(error);
    return null;
  }
}

/** Let the person choose a preset of an arm; null when they would rather not. */
export function chooseArm(studio: Studio): Promise<string | null> {
  const entries = studio.folder.shipped.arms.map((name) => ({ value: name, name, about: "" }));
  return choose(word("panel.chooseAnArm"), portrait(studio, "arm"), [[word("panel.comeWithMjsim"), entries]]);
}

/** A button that shows what is chosen, and opens what there is. */
export function chooser(studio: Studio, kind: Kind, value: string, title: string, press: () => unknown): View {
  const portrait = value ? studio.api.portrait(kind, value, studio.document.path) : "";
  const image = portrait ? html`<img src=${portrait} alt="">` : null;
  return html`<button class="pick" title=${title} @click=${press}>${image}<span class="path">${nameOf(value)}</span></button>`;
}

function modelEntry(path: string): Entry {
  const name = nameOf(path)
    .replace(/\.\w+$/, "")
    .replaceAll("_", " ");
  return { value: path, name, about: path };
}

/** What is offered beside the cards. */
type More = (answer: (value: string | null) => void) => View;

/** Let the person choose one of the cards of some groups, narrowed by a search; with what is offered above and below. */
export function choose(
  title: string,
  portrait: Portrait,
  groups: [head: string, entries: Entry[]][],
  below: More = () => nothing,
  above: More = () => nothing,
): Promise<string | null> {
  return askWith<string>(title, (answer) => {
    const gallery = el("div", { class: "gallery", onkeydown: (event: KeyboardEvent) => walk(gallery, event) });
    const known = new Map<Entry, Known | null>();
    const [first, last] = [above(answer), below(answer)];
    const show = (wish: string): void => {
      const words = wish.toLowerCase().split(/\s+/).filter(Boolean);
      const fits = ({ name, value, about }: Entry): boolean =>
        words.every((word) => `${name} ${value} ${about}`.toLowerCase().includes(word));
      const group = ([head, entries]: [string, Entry[]]): View => {
        const isGone = !entries.some(fits);
        const one = (entry: Entry): View =>
          card(entry, known.get(entry) ?? entry, portrait(entry), !fits(entry), answer);
        return html`<p class="list-title" ?hidden=${isGone}>${head}</p>
          <div class="cards" ?hidden=${isGone}>${entries.map(one)}</div>`;
      };
      const isNone = words.length > 0 && !groups.some(([, entries]) => entries.some(fits));
      const view = html`${first}<input type="search" class="search" aria-label=${word("panel.search")} autofocus
          placeholder=${word("panel.search")} @input=${withValue(show)}><p class="hint" role="status">${
            isNone ? word("panel.nothingIsCalledClearThe", { value: wish }) : ""
          }</p>${groups.map(group)}${last}`;
      draw(gallery, view);
    };
    show("");
    const learn = async (entry: Entry): Promise<unknown> => known.set(entry, (await entry.later) ?? null);
    const later = groups.flatMap(([, entries]) => entries.filter((entry) => entry.later).map(learn));
    void Promise.all(later).then(() => show(gallery.querySelector<HTMLInputElement>("input.search")?.value ?? ""));
    return [gallery];
  });
}

/** The pictures of models, robots and arms. */
function portrait(studio: Studio, kind: Kind): Portrait {
  return (entry) => pictured(studio.api.portrait(kind, entry.value, studio.document.path));
}

/** A picture; what cannot be drawn is still there to be chosen, or to be found wrong by the check of the world. */
export function pictured(src: string): View {
  const without = ({ target }: Event): void =>
    (target as Element).replaceWith(el("span", { class: "hint no-portrait" }, word("panel.noPicture")));
  return html`<img src=${src} alt="" loading="lazy" @error=${without}>`;
}

/** A card: its name and its size stay what they are when more is known of it. */
function card(
  { value, name, later }: Entry,
  { about, fault }: Known,
  portrait: View,
  hidden: boolean,
  answer: (value: string) => void,
): View {
  const told = [about, fault].filter(Boolean).join("");
  return html`<button type="button" class="card" title=${fault ? `${value}: ${fault}` : value} aria-label=${name}
    aria-description=${told} ?hidden=${hidden} @click=${() => answer(value)}>${portrait}<b>${name}</b><span
      class="card-more ${later ? "later" : ""}">${about ? html`<span class="hint">${about}</span>` : null}${
        fault ? html`<span class="card-fault">${sign("warning")}${fault}</span>` : null
      }</span></button>`;
}

/** Arrow keys go through the cards: along the row, and to the next one as they are seen. */
function walk(all: HTMLElement, event: KeyboardEvent): void {
  const cards = [...all.querySelectorAll<HTMLElement>(".card:not([hidden])")];
  const now = cards.indexOf(document.activeElement as HTMLElement);
  const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
  const rows = { ArrowDown: 1, ArrowUp: -1 }[event.key];
  if (now < 0 && event.key === "ArrowDown") cards[0]?.focus();
  else if (now >= 0 && step) cards[now + step]?.focus();
  else if (now >= 0 && rows) below(cards, now, rows)?.focus();
  else return;
  event.preventDefault();
}

/** The card above or below another. */
function below(cards: HTMLElement[], now: number, rows: number): HTMLElement | undefined {
  const here = (cards[now] as HTMLElement).getBoundingClientRect();
  const others = cards.filter((card) => Math.sign(Math.round(card.getBoundingClientRect().top - here.top)) === rows);
  const far = (card: HTMLElement): number => {
    const { left, top } = card.getBoundingClientRect();
    return Math.abs(left - here.left) + 10 * Math.abs(top - here.top);
  };
  return others.sort((one, other) => far(one) - far(other))[0];
}
