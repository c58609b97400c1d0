/** The handles in 3-D of what is selected: they drive the tool that selects, so that the text changes as by the plan. */

import type { Item, Point } from "../api";
import type { Spot } from "../plan/gestures";
import type { Door } from "../scene/door";
import type { Grip, Pull } from "../scene/grip";
import type { Editor } from "./editor";
import { middleOf, wholeGroup } from "./groups";
import { canLift } from "./lift";
import { canTurn, isJoint, isSeated, pivotOf } from "./shapes";
import type { Tools } from "./tools";

/** Let what is selected be held in 3-D while the tool that selects is in hand. */
export function holdSolids(editor: Editor, tools: Tools, door: Door): void {
  let word = "";
  const hold = (): void => {
    const items = tools.now === "select" ? editor.selected : [];
    door.hold(gripOf(items, editor.items), word || wordOf(items));
  };
  editor.document.parsedChanged.on(hold);
  editor.document.selectionChanged.on(hold);
  tools.changed.on(hold);
  editor.dragged.on((ghosts) => door.drag(ghosts));
  door.pulled.on((pull) => {
    follow(tools, editor, pull);
    word = tools.select.word;
    hold();
  });
}

/** Hand a drag in 3-D on to the tool of the plan. */
function follow({ select }: Tools, editor: Editor, pull: Pull): void {
  if (pull.phase === "cancel") return select.cancel();
  if (!select.isHolding) select.take(pull.kind, spotOf(pull, pull.from, editor));
  const spot = spotOf(pull, pull.to, editor);
  if (pull.phase === "drag") select.drag(spot);
  else select.up();
}

function spotOf({ along, alt, rise }: Pull, world: Point, editor: Editor): Spot {
  return { world, screen: editor.plan.view.toScreen(world), shift: along, alt, command: false, touch: false, rise };
}

/** By which handles things are held; null when nothing of them can be done here. */
function gripOf(items: Item[], all: Item[]): Grip | null {
  const free = items.filter((item) => !item.fixed && !isJoint(item) && !isSeated(item));
  const [first] = free;
  if (!first || first !== items[0]) return null;
  const alone = items.length === 1;
  const isGroup = free.length === items.length && wholeGroup(items, all) !== null;
  const axes = first.type === "Opening" ? [first.heading_deg ?? 0] : [0, 90];
  return {
    at: isGroup ? middleOf(items) : pivotOf(first),
    axes: alone || first.type !== "Opening" ? axes : [],
    heading: isGroup ? 0 : alone && canTurn(first) ? (first.heading_deg ?? 0) : null,
    lift: free.some(canLift),
  };
}

/** Why a thing has no handles. */
function wordOf(items: Item[]): string {
  const held = items.find((item) => item.fixed);
  return held?.fixed ? `${held.label}: ${held.fixed}` : "";
}
