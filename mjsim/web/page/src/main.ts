/** Start the studio: colours first, then the folder, then the frame with its views. */

import "./ui/theme.css";
import "./shell/shell.css";
import "./plan/plan.css";
import { api } from "./api";
import { Shell } from "./shell/shell";
import { heedInputMethods } from "./ui/composing";
import { el } from "./ui/dom";
import { heedPresses } from "./ui/press";
import { startTheme } from "./ui/theme";
import "./narrow.css";
import { word } from "./words/words";

startTheme();
heedInputMethods();
heedPresses();
void start();

async function start(): Promise<void> {
  const root = document.getElementById("studio");
  if (!root) return;
  root.querySelector(".opening .hint")?.replaceChildren(word("start.opening"));
  try {
    new Shell(root, await api.folder());
  } catch (error) {
    if (!(error instanceof Error)) throw error;
    const again = el("button", { class: "primary", onclick: () => location.reload() }, word("start.tryAgain"));
    const state = el(
      "div",
      { class: "state", role: "alert" },
      el("h2", {}, word("start.theStudioCannotBe")),
      el("p", {}, error.message),
      again,
    );
    root.replaceChildren(el("header", { class: "bar" }, el("h1", { class: "brand" }, "mjsim")), state);
    console.error(error);
  }
}
