/** Choosing one of many by its picture: models, robots and arms, with a search. */

import type { Studio } from "../shell/view";
import { askWith } from "../ui/dialog";
import { type Child, el, fill } from "../ui/dom";
import { icon } from "../ui/icons";
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
  later?: Promise<Pick<Entry, "about" | "fault"> | null>;
}

/** The picture of an entry; null where there is none. */
type Portrait = (entry: Entry) => HTMLElement | null;

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

/** Let the person choose a preset of a robot; null when they would rather not. */
export function chooseRobot(studio: Studio): Promise<string | null> {
  const entries = studio.folder.shipped.presets.map(({ name, about }) => ({
    value: name,
    name,
    about: meaningOf(about),
  }));
  return choose(word("panel.chooseARobot"), portrait(studio, "robot"), [[word("panel.comeWithMjsim"), entries]]);
}

/** Let the person choose a preset of an arm; null when they would rather not. */
export function chooseArm(studio: Studio): Promise<string | null> {
  const entries = studio.folder.shipped.arms.map((name) => ({ value: name, name, about: "" }));
  return choose(word("panel.chooseAnArm"), portrait(studio, "arm"), [[word("panel.comeWithMjsim"), entries]]);
}

/** A button that shows what is chosen, and opens what there is. */
export function chooser(studio: Studio, kind: Kind, value: string, title: string, press: () => void): HTMLElement {
  const name = el("span", { class: "path" }, nameOf(value));
  const image = value ? el("img", { src: studio.api.portrait(kind, value, studio.document.path), alt: "" }) : null;
  return el("button", { class: "pick", title, onclick: press }, image, name);
}

function modelEntry(path: string): Entry {
  const name = nameOf(path)
    .replace(/\.\w+$/, "")
    .replaceAll("_", " ");
  return { value: path, name, about: path };
}

/** What is offered beside the cards. */
type More = (answer: (value: string | null) => void) => Child[];
const NOTHING: More = () => [];

/** Let the person choose one of the cards of some groups, narrowed by a search; with what is offered above and below. */
export function choose(
  title: string,
  portrait: Portrait,
  groups: [head: string, entries: Entry[]][],
  below = NOTHING,
  above = NOTHING,
): Promise<string | null> {
  return askWith<string>(title, (answer) => {
    const parts = groups
      .filter(([, entries]) => entries.length)
      .map(([head, entries]) => new Group(head, entries, (entry) => card(portrait, entry, answer)));
    const none = el("p", { class: "hint", role: "status" });
    const search = el("input", {
      type: "search",
      class: "search",
      "aria-label": word("panel.search"),
      placeholder: word("panel.search"),
      autofocus: true,
    });
    search.addEventListener("input", () => {
      const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
      const found = parts.map((part) => part.narrow(words)).reduce((sum, count) => sum + count, 0);
      none.textContent = found ? "" : word("panel.nothingIsCalledClearThe", { value: search.value });
    });
    const all = el(
      "div",
      { class: "gallery" },
      ...above(answer),
      search,
      none,
      ...parts.flatMap((part) => part.elements),
      ...below(answer),
    );
    all.addEventListener("keydown", (event) => walk(all, event));
    return [all];
  });
}

/** The pictures of models, robots and arms. */
function portrait(studio: Studio, kind: Kind): Portrait {
  return (entry) => pictured(studio.api.portrait(kind, entry.value, studio.document.path));
}

/** A picture; what cannot be drawn is still there to be chosen, or to be found wrong by the check of the world. */
export function pictured(src: string): HTMLElement {
  const image = el("img", { src, alt: "", loading: "lazy" });
  image.addEventListener("error", () =>
    image.replaceWith(el("span", { class: "hint no-portrait" }, word("panel.noPicture"))),
  );
  return image;
}

/** Cards under a heading; both go where a search leaves nothing. */
class Group {
  readonly elements: HTMLElement[];
  private readonly cards: [HTMLElement, string][];

  constructor(head: string, entries: Entry[], make: (entry: Entry) => HTMLElement) {
    this.cards = entries.map((entry) => [make(entry), `${entry.name} ${entry.value} ${entry.about}`.toLowerCase()]);
    const cards: Child[] = this.cards.map(([card]) => card);
    this.elements = [el("p", { class: "list-title" }, head), el("div", { class: "cards" }, ...cards)];
  }

  /** Leave those that have all words; how many these are. */
  narrow(words: string[]): number {
    let count = 0;
    for (const [card, said] of this.cards) {
      card.hidden = !words.every((word) => said.includes(word));
      count += Number(!card.hidden);
    }
    for (const element of this.elements) element.hidden = count === 0;
    return count;
  }
}

/** A card: its name and its size stay what they are when more is known of it. */
function card(portrait: Portrait, entry: Entry, answer: (value: string) => void): HTMLElement {
  const more = el("span", { class: entry.later ? "card-more later" : "card-more" });
  const tell = (known: Pick<Entry, "about" | "fault">): void => {
    fill(more, ...told(known));
    button.setAttribute("aria-description", more.textContent ?? "");
    if (known.fault) button.title = `${entry.value}: ${known.fault}`;
  };
  const button = el(
    "button",
    {
      type: "button",
      class: "card",
      title: entry.value,
      "aria-label": entry.name,
      onclick: () => answer(entry.value),
    },
    portrait(entry),
    el("b", {}, entry.name),
    more,
  );
  tell(entry);
  void entry.later?.then((later) => later && tell(later));
  return button;
}

function told({ about, fault }: Pick<Entry, "about" | "fault">): HTMLElement[] {
  const sentences = about ? [el("span", { class: "hint" }, about)] : [];
  return fault ? [...sentences, el("span", { class: "card-fault" }, icon("warning"), fault)] : sentences;
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
