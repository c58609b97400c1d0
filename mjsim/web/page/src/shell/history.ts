/** All texts that a world has had, kept as what differs between one and the next. */

import type { Past } from "../api";
import { difference } from "../text/difference";
import { word } from "../words/words";

type Step = Past["steps"][number];

/** Of what is kept beside a draft: so many steps, and so many letters in them. */
const MOST_STEPS = 500;
const MOST_LETTERS = 200_000;
/** The name of a step has so many letters at most. */
const LONGEST_NAME = 100;

export class History {
  private steps: Step[] = [];
  private at = 0;

  constructor(public text = "") {}

  get canUndo(): boolean {
    return this.at > 0;
  }

  get canRedo(): boolean {
    return this.at < this.steps.length;
  }

  /** What each step did, the oldest first, and how many of them lead to the text. */
  get told(): { names: string[]; at: number } {
    return { names: this.steps.map(({ what }) => what ?? word("step.change")), at: this.at };
  }

  /** Take another text, as a step of its own or joined to the last one, which keeps its name. What was undone is gone. */
  push(text: string, joined: boolean, what: string): void {
    if (text === this.text) return;
    this.steps.length = this.at;
    const last = joined ? this.steps.pop() : undefined;
    const before = last ? undone(this.text, last) : this.text;
    if (text !== before)
      this.steps.push({ ...stepBetween(before, text), what: last?.what ?? what.slice(0, LONGEST_NAME) });
    this.at = this.steps.length;
    this.text = text;
  }

  /** Go to the text after so many of the steps. */
  goTo(count: number): void {
    const later = this.steps.slice(this.at, count);
    const sooner = this.steps.slice(count, this.at);
    this.text = later.reduce(redone, sooner.reduceRight(undone, this.text));
    this.at += later.length - sooner.length;
  }

  /** The steps nearest to the text, within bounds. */
  past(): Past {
    let [first, last, letters] = [this.at, this.at, 0];
    const takes = (step: Step | undefined): boolean => {
      letters += step ? step.old.length + step.fresh.length : MOST_LETTERS;
      return letters < MOST_LETTERS && last - first < MOST_STEPS;
    };
    while (takes(this.steps[first - 1])) first--;
    letters = 0;
    while (takes(this.steps[last])) last++;
    return { steps: this.steps.slice(first, last), at: this.at - first };
  }

  /** Take a text with the steps around it, behind those that there are. */
  restore(text: string, { steps, at }: Past): void {
    const before = (later: string | null, step: Step): string | null => (later === null ? null : checked(later, step));
    const first = steps.slice(0, at).reduceRight(before, text as string | null);
    if (first === null) return this.push(text, false, word("step.restore"));
    this.steps.length = this.at;
    this.push(first, false, word("step.restore"));
    this.steps.push(...steps);
    this.at += at;
    this.text = text;
  }
}

function stepBetween(old: string, fresh: string): Step {
  const { from, to, insert } = difference(old, fresh);
  return { from, old: old.slice(from, to), fresh: insert };
}

function undone(text: string, { from, old, fresh }: Step): string {
  return text.slice(0, from) + old + text.slice(from + fresh.length);
}

function redone(text: string, { from, old, fresh }: Step): string {
  return text.slice(0, from) + fresh + text.slice(from + old.length);
}

/** The text before a step; null when the step does not lead to this text. */
function checked(text: string, step: Step): string | null {
  return text.startsWith(step.fresh, step.from) ? undone(text, step) : null;
}
