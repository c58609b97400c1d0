/** Aligns several things and spreads them evenly: each is shifted, the selection as a whole is one change. */

import type { Bounds, Item, Point } from "../api";
import { boundsOf } from "../plan/geometry";
import { word } from "../words/words";
import { type Changed, isJoint, moved } from "./shapes";

export const ARRANGEMENTS = {
  left: word("edit.alignLeftEdges"),
  centre: word("edit.alignCentresLeftToRight"),
  right: word("edit.alignRightEdges"),
  top: word("edit.alignTopEdges"),
  middle: word("edit.alignCentresTopToBottom"),
  bottom: word("edit.alignBottomEdges"),
  across: word("edit.distributeLeftToRight"),
  upright: word("edit.distributeTopToBottom"),
} as const;

export type Arrangement = keyof typeof ARRANGEMENTS;

/** Where along an axis a thing is held: its low end, its middle or its high end. */
const SHARES: Record<Arrangement, { axis: 0 | 1; share: number }> = {
  left: { axis: 0, share: 0 },
  centre: { axis: 0, share: 0.5 },
  right: { axis: 0, share: 1 },
  bottom: { axis: 1, share: 0 },
  middle: { axis: 1, share: 0.5 },
  top: { axis: 1, share: 1 },
  across: { axis: 0, share: 0.5 },
  upright: { axis: 1, share: 0.5 },
};

/** Those of some items that can be put elsewhere on the plan by themselves. */
export function arrangeable(items: Item[]): Item[] {
  return items.filter((item) => item.type !== "Opening" && !isJoint(item) && extentOf(item) !== null);
}

/** What arranging items comes to; nothing when there are too few of them (two to align, three to distribute). */
export function arranged(items: Item[], how: Arrangement, all: Item[]): Changed[] {
  const { axis, share } = SHARES[how];
  const spread = how === "across" || how === "upright";
  const things = arrangeable(items).flatMap((item) => {
    const extent = extentOf(item);
    return extent ? [{ item, at: extent[axis] + share * (extent[(axis + 2) as 2 | 3] - extent[axis]), extent }] : [];
  });
  if (things.length < (spread ? 3 : 2)) return [];
  if (spread) things.sort((a, b) => a.at - b.at);
  const low = Math.min(...things.map(({ extent }) => extent[axis]));
  const high = Math.max(...things.map(({ extent }) => extent[(axis + 2) as 2 | 3]));
  const [first, last] = [things[0]?.at ?? 0, things.at(-1)?.at ?? 0];
  return things.flatMap(({ item, at }, index) => {
    const to = spread ? first + ((last - first) * index) / (things.length - 1) : low + share * (high - low);
    const by: Point = axis === 0 ? [to - at, 0] : [0, to - at];
    return Math.abs(to - at) < 1e-6 ? [] : [moved(item, by, all)];
  });
}

/** What an item takes of the plan, world frame [m]; null when it has no place. */
function extentOf(item: Item): Bounds | null {
  const points = item.polygons.flat();
  if (points.length) return boundsOf(points);
  return item.at ? [...item.at, ...item.at] : null;
}
