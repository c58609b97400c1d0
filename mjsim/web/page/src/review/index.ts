/** The Review view: what was recorded, at any time of it. */

import type { Studio, View } from "../shell/view";
import { ReviewView } from "./view";
import "uplot/dist/uPlot.min.css";
import "../run/run.css";
import "../charts/charts.css";
import "./review.css";
import "./compare.css";

export function makeReviewView(studio: Studio): View {
  return new ReviewView(studio);
}
