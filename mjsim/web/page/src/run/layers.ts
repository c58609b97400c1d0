/** The menu of what is drawn on the plan: a switch for each layer, and one for each thing that modules show. */

import { remembered } from "../ui/controls";
import { chooseColor, chooseDecay, chooseSize, decayOf, LEAST, LONGEST_DECAY, MOST, sizeOf } from "../ui/displays";
import { el } from "../ui/dom";
import { sign } from "../ui/icons";
import { Signal } from "../ui/signal";
import { color, themeChanged } from "../ui/theme";
import { draw, html, nothing, repeat, tickBox, type View, withNumber } from "../ui/view";
import { word } from "../words/words";
import type { Shown } from "./overlay";
import { STAYING as STAYING_READINGS } from "./past";

const LAYERS: [keyof Shown, string][] = [
  ["truth", word("run.truth")],
  ["estimate", word("run.estimate")],
  ["odometry", word("run.odometry")],
  ["trails", word("run.trails")],
  ["ellipses", word("run.ellipses95")],
  ["landmarks", word("run.landmarks")],
  ["sightings", word("run.sightings")],
  ["scans", word("run.lidarScans")],
  ["ring", word("run.proximityRing")],
  ["contacts", word("run.contacts")],
  ["show", word("run.shownByModules")],
];
/** Tokens of the colours of layers, and layers whose lines or points have a size. */
const TOKENS: Partial<Record<keyof Shown, string>> = {
  truth: "--truth",
  estimate: "--estimate",
  odometry: "--odometry",
  landmarks: "--seen",
  scans: "--scanned",
  ring: "--ranged",
  contacts: "--touched",
};
const SIZED: (keyof Shown)[] = [
  ...(["truth", "estimate", "odometry", "trails", "ellipses"] as const),
  ...(["landmarks", "sightings", "scans", "ring", "contacts"] as const),
];
/** Layers that stay for some seconds if that is wanted: paths stay whole otherwise, the rest until the next reading. */
const STAYING: (keyof Shown)[] = ["trails", ...STAYING_READINGS];
/** Layers that are off until somebody wants them. */
const OFF: (keyof Shown)[] = ["ring"];
/** So many things that modules show have switches of their own. */
const MOST_NAMES = 40;

export class Layers {
  readonly element: HTMLDetailsElement;
  readonly changed = new Signal();
  readonly shown: Shown;
  /** Names of what modules show that is not to be seen. */
  readonly hidden: Set<string>;
  private readonly names = new Set<string>();
  private readonly own = el("div", { class: "run-menu-own", role: "group", "aria-label": word("run.shownByModules") });

  constructor() {
    // What was chosen is kept as differences, so that layers that come later begin as they should.
    const kept = new Set((remembered("plan.layers") ?? OFF.map((key) => `-${key}`).join(" ")).split(" "));
    this.shown = Object.fromEntries(LAYERS.map(([key]) => [key, !kept.has(`-${key}`)])) as unknown as Shown;
    this.hidden = new Set(namesIn(remembered("plan.hidden")));
    this.element = this.menu();
  }

  /** Offer a switch for each thing that modules show. */
  offer(names: Iterable<string>): void {
    for (const name of names) {
      if (this.names.has(name) || this.names.size >= MOST_NAMES) continue;
      this.names.add(name);
    }
    this.offerOwn();
  }

  /** Another run is shown: what its modules show is not known yet. */
  forget(): void {
    this.names.clear();
    this.offerOwn();
  }

  private offerOwn(): void {
    const one = (name: string): View =>
      tickBox("", html`<span>${name}</span>`, !this.hidden.has(name), (on) => this.hide(name, !on));
    const rows = repeat(this.names, (name) => name, one);
    draw(this.own, rows);
  }

  private menu(): HTMLDetailsElement {
    const title = word("run.whatIsShown");
    const row = ([key, label]: (typeof LAYERS)[number]): View =>
      html`<div class="run-layer">${tickBox("", html`<span>${label}</span>`, this.shown[key], (on) => this.set(key, on))}${settings(key, label)}</div>`;
    const details = el("details", { class: "run-layers" });
    const view = html`<summary class="button quiet square" title=${title} aria-label=${title}>${sign("layers")}</summary>
        <div class="run-menu" role="group" aria-label=${title}><div class="run-layer hint" aria-hidden="true"
          ><span>${word("run.displaySize")}</span><span>${word("run.displayDecay")}</span></div>
          ${LAYERS.map(row)}${this.own}</div>`;
    draw(details, view);
    document.addEventListener("pointerdown", (event) => {
      if (!details.contains(event.target as Node)) details.open = false;
    });
    details.addEventListener("keydown", (event) => {
      if (event.key === "Escape") details.open = false;
    });
    return details;
  }

  private set(key: keyof Shown, on: boolean): void {
    this.shown[key] = on;
    const off = LAYERS.filter(([each]) => !this.shown[each]).map(([each]) => `-${each}`);
    remembered("plan.layers", off.join(" "));
    this.changed.emit();
  }

  private hide(name: string, hidden: boolean): void {
    if (hidden) this.hidden.add(name);
    else this.hidden.delete(name);
    remembered("plan.hidden", JSON.stringify([...this.hidden].slice(-MOST_NAMES)));
    this.changed.emit();
  }
}

/** Fields for the colour and the size of a layer, as far as it has them. */
function settings(key: keyof Shown, label: string): View {
  const token = TOKENS[key];
  const size = withNumber((factor) => chooseSize(key, factor));
  const factor = html`<input type="range" min=${LEAST} max=${MOST} step="0.5" .value=${String(sizeOf(key))}
    aria-label=${word("run.sizeOf", { label })} @input=${size}>`;
  return [
    SIZED.includes(key) ? factor : nothing,
    STAYING.includes(key) ? decayField(key, label) : nothing,
    token === undefined ? nothing : colorField(token, word("run.colourOf", { label })),
  ];
}

/** Seconds for which a layer stays; empty for as long as usual. */
function decayField(key: keyof Shown, label: string): View {
  const name = word("run.decayOf", { label });
  const decay = ({ target }: Event): void => {
    const field = target as HTMLInputElement;
    if (field.checkValidity()) chooseDecay(key, field.value === "" ? null : Number(field.value));
  };
  return html`<input type="number" min="0" max=${LONGEST_DECAY} step="any" value=${decayOf(key) ?? ""}
    placeholder=${key === "trails" ? word("run.decayNever") : "0 s"} title=${name} aria-label=${name} @input=${decay}>`;
}

/** A colour to choose; a double click takes that of the theme again. */
function colorField(token: string, label: string): HTMLElement {
  const field = el("input", { type: "color", "aria-label": label, title: label });
  const show = (): void => void (field.value = color(token));
  field.addEventListener("input", () => chooseColor(token, field.value));
  field.addEventListener("dblclick", () => chooseColor(token, null));
  themeChanged.on(show);
  show();
  return field;
}

/** The names that were kept; none where what was kept is no list of names. */
function namesIn(kept: string | null): string[] {
  try {
    const names: unknown = JSON.parse(kept ?? "[]");
    return Array.isArray(names) ? names.filter((name) => typeof name === "string") : [];
  } catch {
    return [];
  }
}
