#!/usr/bin/env python3
"""Make docs/classic.md and its pictures anew: the classic experiments, as they come out on this machine."""

import shutil
import textwrap
from pathlib import Path

from mjsim.experiments import Result, run_experiments
from mjsim.experiments.page import number, verdict

ROOT = Path(__file__).resolve().parents[2]
HEAD = """\
# The classic experiments

Five runs that show what a simulator of mobile robots is for. Each is a world of `worlds/classic/`, to be changed and
run like any other; `mjsim experiments -o DIR` makes all of them, with a page of figures, plots and recordings
(`mjsim experiments bump slam -o DIR` two of them; in Python `mjsim.experiments.run_experiments(DIR)`). It exits with
1 when a figure is not as it should be. What follows was written by `scripts/make/classic_page.py`.

How the figures are made: a bump begins at contact and ends after 0.5 s without; the NEES is that of x, y and heading,
averaged over 20 runs with seeds of their own, its band that of chi-square with 60 degrees of freedom over 20
(Bar-Shalom, Li, Kirubarajan 2001, section 5.4.2); coverage is the share of the 0.5 m cells that the robot can reach
which its footprint has touched; triangulation takes each recorded picture by itself, JPEG as it is in the recording,
and uses nothing but the bearings of three recognised beacons or more (Shimshoni 2002), where their own covariance
predicts less than 0.2 m; the last round of SLAM is the last third of the run.
"""


def section(result: Result) -> str:
    """Return an experiment as Markdown."""
    rows = "\n".join(f"| {f.what} | {number(f)} | {f.wanted} | {verdict(f.holds)} |" for f in result.findings)
    pictures = "\n".join(f"\n![{p.caption}](images/classic/{p.name}.png)\n*{p.caption}*" for p in result.pictures)
    world = f"worlds/classic/{result.name}.yaml"
    said = f"{result.question} [{world}](../{world})"
    return (
        f"\n## {result.title}\n\n{textwrap.fill(said, 120, break_long_words=False, break_on_hyphens=False)}\n\n"
        f"| | measured | wanted | |\n|---|---|---|---|\n{rows}\n{pictures}\n"
    )


def main() -> None:
    """Run them all, and write."""
    results = run_experiments(ROOT / "out" / "classic")
    images = ROOT / "docs" / "images" / "classic"
    shutil.rmtree(images, ignore_errors=True)
    images.mkdir(parents=True)
    for result in results:
        for picture in result.pictures:
            (images / f"{picture.name}.png").write_bytes(picture.png)
    (ROOT / "docs" / "classic.md").write_text(HEAD + "".join(map(section, results)), encoding="utf-8")


if __name__ == "__main__":
    main()
