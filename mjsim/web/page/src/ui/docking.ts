/** How large views share their place: one alone, or two parts beside or above each other, each of which may be split again. */

export interface Split {
  way: "row" | "column";
  parts: readonly [Layout, Layout];
}
/** The key of a view, or a split. */
export type Layout = string | Split;
export type Side = "left" | "right" | "top" | "bottom" | "middle";

/** Of the width or height of a view: nearer to an edge, what is dropped splits it there. */
const EDGE = 1 / 3;

/** The views, from left to right and from top to bottom. */
export function keysOf(layout: Layout): string[] {
  return typeof layout === "string" ? [layout] : layout.parts.flatMap(keysOf);
}

/** Leave the views that are there; null where none is. */
export function kept(layout: Layout | null, isThere: (key: string) => boolean): Layout | null {
  if (layout === null || typeof layout === "string") return layout !== null && isThere(layout) ? layout : null;
  const [first, second] = layout.parts.map((part) => kept(part, isThere));
  return first && second ? { way: layout.way, parts: [first, second] } : (first ?? second ?? null);
}

/** Put a view to a side of another, wherever it was before; in the middle it takes the place of the other. */
export function placed(layout: Layout, key: string, at: string, side: Side): Layout {
  if (key === at) return layout;
  const others = kept(layout, (each) => each !== key);
  return others === null ? key : changedAt(others, at, (place) => beside(place, key, side));
}

/** Put a view to a side of all others. */
export function placedBeside(layout: Layout, key: string, side: Exclude<Side, "middle">): Layout {
  const others = kept(layout, (each) => each !== key);
  return others === null ? key : beside(others, key, side);
}

/** How much of a split its first part has unless it is dragged [%]: as many shares as views stand there side by side. */
export function shareOf({ way, parts }: Split): number {
  const [first, second] = parts.map((part) => spanOf(part, way));
  return (100 * (first ?? 1)) / ((first ?? 1) + (second ?? 1));
}

function spanOf(layout: Layout, way: Split["way"]): number {
  if (typeof layout === "string") return 1;
  const [first, second] = layout.parts.map((part) => spanOf(part, way));
  return layout.way === way ? (first ?? 1) + (second ?? 1) : Math.max(first ?? 1, second ?? 1);
}

function changedAt(layout: Layout, at: string, change: (place: string) => Layout): Layout {
  if (typeof layout === "string") return layout === at ? change(layout) : layout;
  const [first, second] = layout.parts;
  return { way: layout.way, parts: [changedAt(first, at, change), changedAt(second, at, change)] };
}

function beside(place: Layout, key: string, side: Side): Layout {
  if (side === "middle") return key;
  const way = side === "left" || side === "right" ? "row" : "column";
  return { way, parts: side === "left" || side === "top" ? [key, place] : [place, key] };
}

/** The side of a view that is nearest to a place in it, both as shares of its width and height. */
export function sideAt(x: number, y: number): Side {
  const ways: [number, Side][] = [
    [x, "left"],
    [1 - x, "right"],
    [y, "top"],
    [1 - y, "bottom"],
  ];
  const [far, side] = ways.reduce((one, other) => (other[0] < one[0] ? other : one));
  return far < EDGE ? side : "middle";
}

/** Read what was kept, also the one or two keys of before; null where it is no layout. */
export function layoutIn(text: string | null): Layout | null {
  if (!text?.startsWith("{")) {
    const [first, second] = text?.split(" ").filter(Boolean) ?? [];
    return first && second ? { way: "row", parts: [first, second] } : (first ?? null);
  }
  try {
    const read: unknown = JSON.parse(text);
    return isLayout(read) && new Set(keysOf(read)).size === keysOf(read).length ? read : null;
  } catch {
    return null;
  }
}

export function layoutText(layout: Layout): string {
  return typeof layout === "string" ? layout : JSON.stringify(layout);
}

function isLayout(value: unknown): value is Layout {
  if (typeof value === "string") return true;
  const { way, parts } = (value ?? {}) as Partial<Split>;
  return (way === "row" || way === "column") && Array.isArray(parts) && parts.length === 2 && parts.every(isLayout);
}
