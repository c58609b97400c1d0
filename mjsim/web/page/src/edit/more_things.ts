/** Everything else that is put down on the plan: a kind of thing, its size or where it looks, and what is chosen for it. */

import type { Path, Values } from "../api";
import { chooseArm, chooseModel, chooser } from "../panel/gallery";
import type { Studio } from "../shell/view";
import { el } from "../ui/dom";
import { word } from "../words/words";
import type { Editor } from "./editor";
import { type Make, PlaceTool, roundMaker, sizedMaker, turnedMaker } from "./place_tool";

/** What is chosen for the things that come in several forms. */
interface Choice {
  model: string;
  arm: string;
}

interface Kind {
  title: string;
  hint: string;
  make(choice: () => Choice): Make;
}

const SIZED = word("edit.clickOrDragFromCorner");
const TURNED = word("edit.clickOrDragToWhere");
const OBSTACLES: Path = ["obstacles"];

const KINDS: Record<string, Kind> = {
  ramp: {
    title: word("edit.ramp"),
    hint: SIZED,
    make: () => sizedMaker(OBSTACLES, "ramp", [2, 1], (sides) => ({ ramp: [...sides, 0.2] })),
  },
  steps: {
    title: word("edit.steps"),
    hint: SIZED,
    make: () => sizedMaker(OBSTACLES, "steps", [1, 1], (sides) => ({ steps: [...sides, 0.3], count: 3 })),
  },
  platform: {
    title: word("edit.platform"),
    hint: SIZED,
    make: () => sizedMaker(OBSTACLES, "obstacle", [2, 2], (sides) => ({ box: [...sides, 0.2] })),
  },
  sphere: {
    title: word("edit.sphere"),
    hint: word("edit.clickOrDragFromIts"),
    make: () => roundMaker(OBSTACLES, (radius) => ({ sphere: radius })),
  },
  model: {
    title: word("edit.model"),
    hint: TURNED,
    make: (choice) => turnedMaker(OBSTACLES, "obstacle", 0.3, () => ({ model: choice().model })),
  },
  area: {
    title: word("edit.areaOfFloor"),
    hint: SIZED,
    make: () => sizedMaker(["floor", "patches"], "patch", [2, 1.5], (sides) => ({ size: sides, color: "#93a878" })),
  },
  lamp: {
    title: word("edit.lamp"),
    hint: word("edit.click"),
    make: () => turnedMaker(["lamps"], "light", 0, () => ({ height: 2.4 })),
  },
  person: {
    title: word("edit.person"),
    hint: TURNED,
    make: () => turnedMaker(["people"], "obstacle", 0.25, () => ({ name: "person", sex: "female" })),
  },
  arm: {
    title: word("edit.arm"),
    hint: TURNED,
    make: (choice) =>
      turnedMaker(["robots"], "robot", 0.15, () => ({ name: "arm", base: "fixed", arms: [{ preset: choice().arm }] })),
  },
  mechanism: {
    title: word("edit.mechanism"),
    hint: TURNED,
    make: () => turnedMaker(["mechanisms"], "obstacle", 0.5, pendulum),
  },
};

/** A mechanism to begin with: a rod that swings. */
function pendulum(): Values {
  return {
    name: "pendulum",
    elevation: 1.5,
    bodies: [{ name: "rod", rod: [1, 0.03] }],
    joints: [{ revolute: "q", of: ["ground", "rod"], axis: [0, 1, 0], start_deg: 45 }],
  };
}

export class MoreThings {
  readonly tool: PlaceTool;
  private kind = "ramp";
  private readonly choice: Choice;

  constructor(private readonly editor: Editor) {
    const { models, arms } = editor.studio.folder.shipped;
    this.choice = { model: models[0] ?? "", arm: arms[0] ?? "" };
    const makes = Object.fromEntries(Object.entries(KINDS).map(([name, kind]) => [name, kind.make(() => this.choice)]));
    this.tool = new PlaceTool(editor, (...spot) => (makes[this.kind] as Make)(...spot));
  }

  get hint(): string {
    return KINDS[this.kind]?.hint ?? "";
  }

  /** What is chosen in the strip; `again` draws that anew. */
  choices(again: () => void): HTMLElement[] {
    const kind = options(
      word("edit.kind"),
      Object.entries(KINDS).map(([name, { title }]) => [name, title]),
      this.kind,
      (name) => {
        this.kind = name;
        again();
      },
    );
    if (this.kind !== "model" && this.kind !== "arm") return [kind];
    return [
      kind,
      this.kind === "model"
        ? this.button("model", word("edit.chooseAModel"), chooseModel, again)
        : this.button("arm", word("edit.chooseAnArm"), chooseArm, again),
    ];
  }

  /** Shows what is chosen, and lets choose another. */
  private button(
    form: keyof Choice,
    title: string,
    ask: (studio: Studio) => Promise<string | null>,
    again: () => void,
  ): HTMLElement {
    const { studio } = this.editor;
    const choose = async (): Promise<void> => {
      this.choice[form] = (await ask(studio)) ?? this.choice[form];
      again();
    };
    return chooser(studio, form, this.choice[form], title, () => void choose());
  }
}

function options(label: string, names: [string, string][], now: string, chosen: (name: string) => void): HTMLElement {
  const each = names.map(([value, title]) => el("option", { value, selected: value === now }, title));
  const select = el("select", { "aria-label": label }, ...each);
  select.addEventListener("change", () => chosen(select.value));
  return select;
}
