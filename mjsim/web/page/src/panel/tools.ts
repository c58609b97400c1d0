/** What the controls of a form need of the studio: pictures, names and modules. */

import type { Path } from "../api";
import type { Studio } from "../shell/view";
import type { Tools } from "./controls";
import type { ModuleShelf } from "./modules";
import { drivenParts, partsNamed, robotAt } from "./offers";
import { choosePicture } from "./pictures";

export function toolsFor(studio: Studio, shelf: ModuleShelf): Tools {
  return {
    picture: (path) => studio.api.picture(path, 96, studio.document.path),
    choosePicture: () => choosePicture(studio),
    suggestions: (id) => suggestions(studio, JSON.parse(id) as Path),
    names: (path) => names(studio, path),
    module: (use) => shelf.find(use),
    chooseModule: (path) => shelf.choose(path),
  };
}

function suggestions(studio: Studio, path: Path): string[] {
  const { items } = studio.document;
  const [list, , key, ...deeper] = path;
  if (list === "run") return partsNamed(robotAt(path, items), String(path.at(-1)));
  if (deeper.length) return [];
  if (list === "robots" && key === "preset") return studio.folder.shipped.presets.map(({ name }) => name);
  const carriers = items.filter((item) => ["robots", "obstacles"].includes(String(item.path[0])));
  return list === "beacons" && key === "on" ? carriers.flatMap(({ name }) => name ?? []) : [];
}

/** Keys of a map that the names of things tell: robots that can have modules, and parts that a controller can drive. */
function names(studio: Studio, path: Path): string[] {
  const { items } = studio.document;
  if (path.at(-1) === "controllers") return drivenParts(robotAt(path, items));
  const robots = items.filter((item) => item.type === "Robot").flatMap(({ name }) => name ?? []);
  return path.join("/") === "run/drivers" ? robots : [];
}
