/** Everything else that is put down on the plan: a kind of thing, its size or where it looks, and what is chosen for it. */

import type { Path, Values } from "../api";
import { chooseArm, chooseModel, chooser } from "../panel/gallery";
import type { Studio } from "../shell/view";
import { choice, nothing, type View } from "../ui/view";
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

/** The title, the hint and the maker of each kind. */
function kind(title: string, hint: string, make: Kind["make"]): Kind {
  return { title, hint, make };
}

const KINDS: Record<string, Kind> = {
  ramp: kind(word("edit.ramp"), SIZED, () =>
    sizedMaker(OBSTACLES, "ramp", [2, 1], (sides) => ({ ramp: [...sides, 0.2] })),
  ),
  steps: kind(word("edit.steps"), SIZED, () =>
    sizedMaker(OBSTACLES, "steps", [1, 1], (sides) => ({ steps: [...sides, 0.3], count: 3 })),
  ),
  platform: kind(word("edit.platform"), SIZED, () =>
    sizedMaker(OBSTACLES, "obstacle", [2, 2], (sides) => ({ box: [...sides, 0.2] })),
  ),
  sphere: kind(word("edit.sphere"), word("edit.clickOrDragFromIts"), () =>
    roundMaker(OBSTACLES, (radius) => ({ sphere: radius })),
  ),
  model: kind(word("edit.model"), TURNED, (choice) =>
    turnedMaker(OBSTACLES, "obstacle", 0.3, () => ({ model: choice().model })),
  ),
  area: kind(word("edit.areaOfFloor"), SIZED, () =>
    sizedMaker(["floor", "patches"], "patch", [2, 1.5], (sides) => ({ size: sides, color: "#93a878" })),
  ),
  lamp: kind(word("edit.lamp"), word("edit.click"), () => turnedMaker(["lamps"], "light", 0, () => ({ height: 2.4 }))),
  person: kind(word("edit.person"), TURNED, () =>
    turnedMaker(["people"], "obstacle", 0.25, () => ({ name: "person", sex: "female" })),
  ),
  arm: kind(word("edit.arm"), TURNED, (choice) =>
    turnedMaker(["robots"], "robot", 0.15, () => ({ name: "arm", base: "fixed", arms: [{ preset: choice().arm }] })),
  ),
  mechanism: kind(word("edit.mechanism"), TURNED, () => turnedMaker(["mechanisms"], "obstacle", 0.5, pendulum)),
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
  choices(again: () => void): View {
    const choose = (kind: string): void => {
      this.kind = kind;
      again();
    };
    const kinds = Object.entries(KINDS).map(([name, { title }]) => [name, title] as const);
    const form =
      this.kind === "model"
        ? this.button("model", word("edit.chooseAModel"), chooseModel, again)
        : this.kind === "arm"
          ? this.button("arm", word("edit.chooseAnArm"), chooseArm, again)
          : nothing;
    return [choice(word("edit.kind"), kinds, this.kind, choose), form];
  }

  /** Shows what is chosen, and lets choose another. */
  private button(
    form: keyof Choice,
    title: string,
    ask: (studio: Studio) => Promise<string | null>,
    again: () => void,
  ): View {
    const { studio } = this.editor;
    const choose = async (): Promise<void> => {
      this.choice[form] = (await ask(studio)) ?? this.choice[form];
      again();
    };
    return chooser(studio, form, this.choice[form], title, choose);
  }
}
