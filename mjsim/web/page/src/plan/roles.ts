/** How each role of a plan is drawn, as in all pictures. Made by scripts/make/protocol.py; do not edit. */

import type { Tokens } from "../ui/ink";

type Ink = keyof Tokens | "tint";

/** A colour and a fraction of another; 'tint' is a thing's own colour. */
export type Mix = readonly [Ink, Ink, number];

export interface Style {
  fill?: Mix;
  line?: Mix;
  /** [mm on paper] */
  width: number;
  /** Length of dashes, whose gaps are half as long [mm on paper]. */
  dash?: number;
}

export const ROLES: Record<string, Style> = {
  patch: { fill: ["tint", "paper", 0.72], line: ["tint", "paper", 0.3], width: 0.15, dash: 1.2 },
  "low wall": { fill: ["wall", "paper", 0.6], line: ["wall", "paper", 0.6], width: 0.1 },
  obstacle: { fill: ["tint", "paper", 0.5], line: ["tint", "ink", 0.45], width: 0.2 },
  movable: { fill: ["tint", "paper", 0.5], line: ["tint", "ink", 0.45], width: 0.3, dash: 1.2 },
  hanging: { line: ["tint", "ink", 0.3], width: 0.12, dash: 0.8 },
  tread: { line: ["tint", "ink", 0.45], width: 0.15 },
  "way up": { fill: ["tint", "ink", 0.45], line: ["tint", "ink", 0.45], width: 0.25 },
  wall: { fill: ["wall", "paper", 0], line: ["wall", "paper", 0], width: 0.1 },
  window: { line: ["glass", "paper", 0], width: 0.3 },
  gap: { line: ["muted", "paper", 0.4], width: 0.15, dash: 0.6 },
  swing: { line: ["muted", "paper", 0], width: 0.12 },
  leaf: { fill: ["tint", "ink", 0.25], line: ["tint", "ink", 0.25], width: 0.3 },
  route: { fill: ["muted", "paper", 0], line: ["muted", "paper", 0], width: 0.3, dash: 0.7 },
  lamp: { fill: ["lamp", "paper", 0], line: ["lamp", "paper", 0], width: 0.2 },
  person: { fill: ["tint", "paper", 0.5], line: ["tint", "ink", 0.45], width: 0.15 },
  robot: { fill: ["tint", "paper", 0.5], line: ["ink", "paper", 0], width: 0.3 },
  heading: { fill: ["ink", "paper", 0], line: ["ink", "paper", 0], width: 0.4 },
  link: { fill: ["tint", "paper", 0.35], line: ["ink", "paper", 0], width: 0.2 },
  tool: { fill: ["ink", "paper", 0], width: 0.2 },
  beacon: { line: ["beacon", "paper", 0], width: 0.7 },
  tick: { line: ["beacon", "paper", 0], width: 0.4 },
  marker: { line: ["paper", "paper", 0], width: 0.25 },
  reflector: { fill: ["paper", "paper", 0], line: ["beacon", "paper", 0], width: 0.3 },
};
