/** Choosing a model of MJCF or URDF, of those that come with mjsim, by its name and its outline from above. */

import type { Item } from "../api";
import { el } from "../dom";
import { boundsOf } from "../plan/geometry";
import { askWith } from "../shell/dialog";
import type { Studio } from "../shell/view";

/** Side of an outline's picture [px], and what it shows [m]. */
const SIDE = 120;
const SHOWN = 1.8;
const SPACE = "http://www.w3.org/2000/svg";

/** Let the person choose; null when they would rather not. */
export async function chooseModel(studio: Studio): Promise<string | null> {
  const { models } = studio.folder.shipped;
  const lines = models.map((model) => `  - {model: ${JSON.stringify(model)}, at: [0, 0]}\n`);
  // The server knows what they look like from above.
  const parsed = await studio.api.parse("", `mjsim: 1\nobstacles:\n${lines.join("")}`);
  return askWith<string>("Choose a model", (answer) => {
    const cards = models.map((path, index) => {
      const item = parsed.items?.find((other) => other.path[1] === index);
      const [name, size] = [path.replace(/^.*\//, ""), item ? sizeOf(item) : ""];
      const parts = [item ? outline(item) : null, el("span", {}, name), el("span", { class: "hint" }, size)];
      return el("button", { type: "button", class: "card", title: path, onclick: () => answer(path) }, ...parts);
    });
    return [el("p", { class: "list-title" }, "Come with mjsim, from above"), el("div", { class: "cards" }, ...cards)];
  });
}

function sizeOf(item: Item): string {
  const [x0, y0, x1, y1] = boundsOf(item.polygons.flat());
  return `${(x1 - x0).toFixed(2)} × ${(y1 - y0).toFixed(2)} m`;
}

/** An item from above, all at one scale, as wide as a card. */
function outline(item: Item): SVGSVGElement {
  const svg = document.createElementNS(SPACE, "svg");
  const attributes = { viewBox: `${-SIDE / 2} ${-SIDE / 2} ${SIDE} ${SIDE}`, class: "outline-picture", "aria-hidden": "true" };
  for (const [name, value] of Object.entries(attributes)) svg.setAttribute(name, value);
  for (const polygon of item.polygons) {
    const shape = document.createElementNS(SPACE, "polygon");
    shape.setAttribute("points", polygon.map(([x, y]) => `${(x * SIDE) / SHOWN},${(-y * SIDE) / SHOWN}`).join(" "));
    svg.append(shape);
  }
  return svg;
}
