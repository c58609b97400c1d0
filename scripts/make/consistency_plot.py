#!/usr/bin/env python3
"""Plot the average NEES of the three EKF-SLAM filters over 50 runs of one loop in a ring of landmarks.

For instance `.venv/bin/python scripts/make/consistency_plot.py -o docs/images/consistency.png`.
"""

import argparse
from pathlib import Path

import matplotlib as mpl
import numpy as np
from scipy.stats import chi2

from mjsim.algorithms.ekf_slam.ekf_slam import EkfSlamFilter, InvariantEkfSlamFilter
from mjsim.bench.consistency import ring_nees

START = (10.0, 0.0, np.pi / 2)
FILTERS = {
    "standard": lambda: EkfSlamFilter(pose=START),
    "first-estimates": lambda: EkfSlamFilter(jacobians="first-estimates", pose=START),
    "invariant": lambda: InvariantEkfSlamFilter(pose=START),
}
COLORS = {"standard": "#c0392b", "first-estimates": "#1f5fa8", "invariant": "#2e8b57"}


def main() -> None:
    """Run the filters, print the share of time in the band, draw the plot."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=50)
    parser.add_argument("-o", "--output", type=Path, default=Path("docs/images/consistency.png"))
    given = parser.parse_args()
    mpl.use("Agg")
    import matplotlib.pyplot as plt

    low, high = chi2.ppf([0.025, 0.975], 3 * given.runs) / given.runs
    figure, axes = plt.subplots(figsize=(9, 4.2), layout="constrained")
    axes.axhspan(low, high, color="#d8e6d8", label=f"95 % band of {given.runs} runs")
    for name, make in FILTERS.items():
        average = np.mean([ring_nees(make(), seed) for seed in range(given.runs)], axis=0)
        inside = np.mean((average > low) & (average < high))
        print(f"{name:16s} in the band {100 * inside:5.1f} % of the time, mean {average.mean():.2f}", flush=True)
        axes.plot(average, color=COLORS[name], linewidth=1.4, label=f"{name}: inside {100 * inside:.0f} %")
    axes.set(xlabel="update", ylabel="average NEES of the pose, three states")
    axes.legend(frameon=False)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    figure.savefig(given.output, dpi=110)


if __name__ == "__main__":
    main()
