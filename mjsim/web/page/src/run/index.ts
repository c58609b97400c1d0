/** The Run view: what goes on in a simulated world, live. */

import type { Studio, View } from "../shell/view";
import { RunView } from "./view";
import "uplot/dist/uPlot.min.css";
import "./run.css";
import "../charts/charts.css";

export function makeRunView(studio: Studio): View {
  return new RunView(studio);
}
