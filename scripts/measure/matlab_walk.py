#!/usr/bin/env python3
"""Time a MATLAB user's walk: a script of two arms with films, a configuration, a run, a report, the user's estimator.

    .venv/bin/python scripts/measure/matlab_walk.py -o DIR

It prints a row for each command: seconds on the clock, and seconds of processor time.
"""

import argparse
import os
import re
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "tutorials" / "from-matlab.md"
SCRIPT = """clear all; close all; clc
L1 = link([0 1 0 0 0]); L2 = link([0 0.8 0 0 0]);
two = robot({L1 L2}, 'two');
t = (0:0.05:2)';
[q, qd] = jtraj([0 0], [pi/2 -pi/3], t);
figure(1); subplot(2,1,1); plot(t, q); ylabel('q [rad]'); subplot(2,1,2); plot(t, qd); xlabel('time [s]')
figure(2); plot(two, q);
puma560
[q6, qd6, qdd6] = jtraj(qz, qr, t);
figure(3); plot(t, rne(p560, q6, qd6, qdd6)); xlabel('time [s]'); ylabel('torque [N m]')
figure(4); plot(p560, q6);
"""
CONFIG = """corners = [0 6 6 0 0; 0 0 4 4 0];
beacons = [1 3 5 5.9 3 0.1; 3.9 3.9 3.9 2 0.1 2; -90 -90 -90 180 90 0; 1 2 3 4 5 6];
robot.radius = 0.2; robot.wheelbase = 0.3;
wp = [1 5 5 1; 1 1 3 3];
"""
COMMANDS = (
    "octave two_arms.m -o out",
    "new --from config.m -o room.yaml",
    "run room.yaml -o run.mcap --seconds 30",
    "report run.mcap -o report",
    "run mine.yaml -o mine.mcap --seconds 30",
    "compare run.mcap mine.mcap -o compared",
)


def main() -> None:
    """Run the walk in a new folder."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", type=Path, required=True, metavar="DIR", help="a new folder")
    folder = parser.parse_args().o
    folder.mkdir(parents=True)
    (folder / "two_arms.m").write_text(SCRIPT)
    (folder / "config.m").write_text(CONFIG)
    estimator = re.search(r":caption: my_ekf\.m\n\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert estimator is not None, f"no my_ekf.m in {PAGE}"
    (folder / "my_ekf.m").write_text(estimator[1])
    for command in COMMANDS:
        if "mine.yaml" in command:
            room = (folder / "room.yaml").read_text().replace("\nrun:\n", "\nrun:\n  map: known\n")
            (folder / "mine.yaml").write_text(re.sub(r"estimator: .*", "estimator: {use: my_ekf.m}", room))
        began, before = time.perf_counter(), os.times()
        subprocess.run(
            [sys.executable, "-m", "mjsim.cli", *command.split()], cwd=folder, check=True, capture_output=True
        )
        after = os.times()
        used = after.children_user + after.children_system - before.children_user - before.children_system
        print(f"{time.perf_counter() - began:6.1f} s {used:6.1f} s  mjsim {command}")


if __name__ == "__main__":
    main()
