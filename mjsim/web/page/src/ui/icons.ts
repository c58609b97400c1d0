/** Icons of the studio: lines in a square of 20. */

import { draw, html, type View } from "./view";

const ICONS = {
  select: "M5 3l10.5 7-5 1.2L8.2 16z",
  hand: "M6.5 10V5.5a1.25 1.25 0 0 1 2.5 0V9m0-4.5a1.25 1.25 0 0 1 2.500 0V9m0-3.500a1.250 1.250 0 0 1 2.500 0V12c0 3-1.800 5-4.500 5-2.300 0-3.200-1-4.200-3L3.600 11.200c-.6-1.200.9-2.100 1.800-1L6.500 11.500",
  touch:
    "M8 9V4.500a1.250 1.250 0 0 1 2.500 0V9l4 1.200a1.600 1.600 0 0 1 1.200 1.800l-.700 4.500H9L5.800 12.300c-.900-1.200.800-2.300 1.700-1.300L8 11.500M5.500 6A4 4 0 0 1 13 6",
  wall: "M3 16V8l8-4.500h6M3 16h4M7 16V10l5-2.800h5",
  door: "M3 16h3M14 16h3M6 16V5.500M6 5.500A10.500 10.500 0 0 1 14 16",
  window: "M2.500 10h3M14.500 10h3M5.500 7.500h9v5h-9zM5.500 10h9",
  box: "M4 6.500h12v8.500H4z",
  cylinder: "M10 4.500a5.500 5.500 0 1 1 0 11 5.500 5.500 0 1 1 0-11z",
  beacon: "M4 4h12v12H4zM4 13l3.500-3.500 3 3 2-2L16 14M12.700 7.300h.01",
  robot: "M10 3.500a6.500 6.500 0 1 1 0 13 6.500 6.500 0 1 1 0-13zM10 10h6.500",
  undo: "M4 8.500h8a4 4 0 0 1 0 8H8M4 8.500l3.500-3.500M4 8.500L7.500 12",
  redo: "M16 8.500H8a4 4 0 0 0 0 8h4M16 8.500l-3.500-3.500M16 8.500L12.500 12",
  more: "M3.500 16.500h5v-5h-5zM10.500 16.500l3-5 3 5zM6 3.500a2.500 2.500 0 1 1 0 5 2.500 2.500 0 1 1 0-5zM13.500 4v5M11 6.500h5",
  steps: "M8 5h8.500M8 10h8.500M8 15h8.500M3.500 5h1M3.500 10h1M3.500 15h1",
  fit: "M3.500 7.500v-4h4M12.500 3.500h4v4M16.500 12.500v4h-4M7.500 16.500h-4v-4",
  plus: "M10 4v12M4 10h12",
  minus: "M4 10h12",
  globe:
    "M10 2.500a7.500 7.500 0 1 1 0 15 7.500 7.500 0 1 1 0-15zM2.500 10h15M10 2.500c5 4 5 11 0 15M10 2.500c-5 4-5 11 0 15",
  sun: "M10 6.500a3.500 3.500 0 1 1 0 7 3.500 3.500 0 1 1 0-7zM10 2v1.500M10 16.500V18M2 10h1.500M16.500 10H18M4.300 4.300l1.100 1.100M14.600 14.600l1.100 1.100M4.300 15.700l1.100-1.100M14.600 5.400l1.100-1.100",
  moon: "M16.500 11.500A7 7 0 0 1 8.500 3.500a7 7 0 1 0 8 8z",
  open: "M2.500 15.500v-10h5l1.500 2h8.500v8z",
  new: "M5 2.500h6.500L15.500 6.500v11H5zM11.500 2.500v4h4M10 9.500v5M7.500 12h5",
  save: "M3.500 3.500h10.500l2.500 2.500v10.500h-13zM6.500 3.500v4.500h6v-4.500M6 16.500v-5h8v5",
  copy: "M7 7h9.500v9.500H7zM13 7V3.500H3.500V13H7",
  trash: "M4 5.500h12M8 5.500v-2h4v2M5.500 5.500l.8 11h7.400l.8-11M8.500 8.500v5M11.500 8.500v5",
  reset: "M4.500 4v4h4M4.800 8a6 6 0 1 1-.6 4",
  share: "M8.500 4H4v12h12v-4.500M11.500 3.500h5v5M16.500 3.500L9 11",
  help: "M7.500 7.500a2.500 2.500 0 1 1 3.600 2.200c-.8.4-1.100.9-1.100 1.800M10 14.500h.01M10 2.500a7.500 7.500 0 1 1 0 15 7.500 7.500 0 1 1 0-15z",
  text: "M4 5h12M4 8.500h8M4 12h12M4 15.500h7",
  warning: "M10 3l7.500 13.500h-15zM10 8v4M10 14.300h.01",
  lock: "M5 9h10v7.500H5zM7 9V6.500a3 3 0 0 1 6 0V9",
  repeat: "M3 4h5v5H3zM8 11h5v5H8zM12 4h5v5h-5z",
  include:
    "M8.500 11.500l3-3M7 9.500L4.700 11.800a2.500 2.500 0 0 0 3.500 3.500L10.500 13M9.500 7l2.300-2.300a2.500 2.500 0 0 1 3.500 3.500L13 10.500",
  down: "M5.500 8l4.500 4.500L14.500 8",
  play: "M6 4l10 6-10 6z",
  turn: "M15.500 6.500A6.500 6.500 0 1 0 16.500 10M16.500 3v4h-4",
  left: "M3.500 3v14M6 5h10v3.500H6zM6 11.500h6V15H6z",
  centre: "M10 3v2M10 8.500v3M10 15v2M4.500 5h11v3.500h-11zM6.500 11.500h7V15h-7z",
  right: "M16.500 3v14M4 5h10v3.500H4zM8 11.500h6V15H8z",
  top: "M3 3.500h14M5 6v10h3.500V6zM11.500 6v6H15V6z",
  middle: "M3 10h2M8.500 10h3M15 10h2M5 4.500v11h3.500v-11zM11.500 6.500v7H15v-7z",
  bottom: "M3 16.500h14M5 4v10h3.500V4zM11.500 8v6H15V8z",
  across: "M3.500 3v14M16.500 3v14M8 6h4v8H8z",
  upright: "M3 3.500h14M3 16.500h14M6 8h8v4H6z",
  pause: "M7 4v12M13 4v12",
  step: "M5 4l7 6-7 6zM15 4v12",
  restart: "M4.2 10a5.9 5.9 0 1 0 2-4.4M6 2.2v3.6h3.6",
  stop: "M5 5h10v10H5z",
  beside: "M3 4h14v12H3zM10 4v12M13.500 8v4M11.700 10h3.600",
  enlarge: "M12 3h5v5M17 3l-6 6M8 17H3v-5M3 17l6-6",
  follow: "M10 2v3.5M10 14.5V18M2 10h3.5M14.5 10H18M10 6.5a3.5 3.5 0 1 0 0 7 3.5 3.5 0 0 0 0-7z",
  layers: "M10 3l7 3.7-7 3.7-7-3.7zM3 10.4l7 3.7 7-3.7M3 14l7 3.7 7-3.7",
  up: "M4 12l6-6 6 6",
  arrowLeft: "M12 4l-6 6 6 6",
  arrowRight: "M8 4l6 6-6 6",
  turnLeft: "M6 9a5.5 5.5 0 1 1 1.6 5M6 4v5h5",
  turnRight: "M14 9a5.5 5.5 0 1 0-1.6 5M14 4v5H9",
  film: "M3 4h14v12H3zM7 4v12M13 4v12",
  download: "M10 3v9M6.2 8.6l3.8 3.8 3.8-3.8M4 16.5h12",
  side: "M3 4h14v12H3zM8 4v12",
  goal: "M6 17V3M6 3l9 3.5L6 10",
  ruler: "M3 13L13 3l4 4L7 17zM6 10l1.8 1.8M8.5 7.5l1.8 1.8M11 5l1.8 1.8",
  close: "M5 5l10 10M15 5L5 15",
} as const;

export type IconName = keyof typeof ICONS;

/** An icon, in lines of the text's colour. */
export function sign(name: IconName): View {
  return html`<svg viewBox="0 0 20 20" class="icon" aria-hidden="true"><path d=${ICONS[name]}></path></svg>`;
}

/** A button that shows an icon, and has its title as its name. */
export function iconButton(name: IconName, title: string, press: () => void, disabled = false, kind = "quiet"): View {
  return html`<button type="button" class="${kind} square" title=${title} aria-label=${title} ?disabled=${disabled}
    @click=${press}>${sign(name)}</button>`;
}

/** The same as an element, for what is made once. */
export function icon(name: IconName): SVGSVGElement {
  const place = document.createElement("span");
  draw(place, sign(name));
  return place.firstElementChild as SVGSVGElement;
}
