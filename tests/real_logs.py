"""Text files as real robots leave them, written from motions that are known exactly."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest

from mjsim.cli import main
from mjsim.geometry import Array, Pose, wrap_angle
from mjsim.logs import Wishes
from mjsim.logs.log_kinds import convert
from mjsim.logs.resampling.record_output import recorded
from mjsim.record import Recording

START = 1248272272.84
"""Time of the log at its start, as clocks of computers count [s]."""
LANDMARKS = {6: (4.0, 0.5), 7: (3.0, 3.5), 8: (-1.0, 3.0), 9: (-1.5, -1.0), 10: (2.0, -2.5)}
CODES = {1: 5, 2: 14, 6: 63, 7: 81, 8: 7, 9: 70, 10: 45}


def write_table(path: Path, rows: Iterable[Iterable[float]], head: str = "") -> None:
    lines = ["\t".join(repr(value) if isinstance(value, int) else f"{value:.9f}" for value in row) for row in rows]
    path.write_text(head + "\n".join(lines) + "\n")


def circle(start: Pose, forward: float, turn: float, times: Array) -> Array:
    """Return (x, y, heading) on the arc of a constant twist, shape (N, 3): the closed form about its centre."""
    radius = forward / turn
    headings = start.heading + turn * times
    x = start.x + radius * (np.sin(headings) - np.sin(start.heading))
    y = start.y - radius * (np.cos(headings) - np.cos(start.heading))
    return np.stack([x, y, headings], axis=-1)


def write_mrclam(
    folder: Path, *, seconds: float = 12.0, numbers: tuple[int, ...] = (1,), seed: int = 0
) -> dict[int, Pose]:
    """Write a data set in which each robot drives a circle; return where each starts.

    Velocities are told at about 67 Hz, poses at 100 Hz and sightings at odd times, all without error.
    """
    rng = np.random.default_rng(seed)
    folder.mkdir(exist_ok=True)
    write_table(folder / "Barcodes.dat", CODES.items(), "# Subject #    Barcode #\n")
    write_table(
        folder / "Landmark_Groundtruth.dat", ([n, x, y, 0.0001, 0.0002] for n, (x, y) in LANDMARKS.items()), "# x y\n"
    )
    starts = {number: Pose(0.2 * number, -0.3 * number, 0.4 * number) for number in numbers}
    for number, start in starts.items():
        twist = (0.3, 0.25)
        times = np.arange(0.0, seconds, 0.01)
        poses = circle(start, *twist, times)
        named = folder / f"Robot{number}"
        wrapped = np.column_stack([START + times, poses[:, :2], [wrap_angle(heading) for heading in poses[:, 2]]])
        write_table(Path(f"{named}_Groundtruth.dat"), wrapped.tolist(), "# Time [s]    x [m]    y [m]\n")
        told = np.cumsum(rng.uniform(0.01, 0.02, int(seconds * 70)))
        told = told[told < seconds]
        write_table(Path(f"{named}_Odometry.dat"), ([START + t, *twist] for t in (0.0, *told)), "# Time [s]\n")
        rows: list[list[float]] = []
        for time in np.sort(rng.uniform(0.0, seconds, int(seconds * 5))):
            x, y, heading = circle(start, *twist, np.array([time]))[0]
            for landmark, place in LANDMARKS.items():
                ahead, left = Pose(x, y, heading).inverse().transform(place)
                if ahead > 0.1:  # The camera tells the depth along its axis.
                    rows.append([START + time, CODES[landmark], ahead, np.arctan2(left, ahead)])
            rows.append([START + time, 14 if number == 1 else 5, 1.0, 0.1])
            rows.append([START + time, 99, 1.0, 0.1])
        write_table(Path(f"{named}_Measurement.dat"), [[t, int(c), r, b] for t, c, r, b in rows], "# Time [s]\n")
    return starts


TREES = ((12.0, 3.0), (18.0, -6.0), (30.0, 8.0), (8.0, 15.0), (20.0, 16.0), (5.0, 28.0))
CAR = (2.0, 0.1)
"""Speed of the middle of the rear axle [m/s] and steering angle [rad]."""


def write_victoria_park(folder: Path, *, seconds: float = 20.0, begin: float = 1.0) -> Pose:
    """Write a log of a car on a circle, without error; there is no fix from 8 to 12 s. Returns where it starts."""
    folder.mkdir(exist_ok=True)
    speed, steering = CAR
    turn = speed * np.tan(steering) / 2.83
    start = Pose(-2.0, -1.9, 0.3)
    times = np.arange(0.0, seconds, 0.025)
    wheel = speed - turn * 0.76
    write_table(folder / "inputs.dat", ([begin + t, wheel, steering] for t in times))
    fixes = np.arange(0.0, seconds, 0.2)
    fixes = fixes[(fixes < 8.0) | (fixes > 12.0)]
    places = circle(start, speed, turn, fixes)
    antenna = [Pose.from_array(place).transform((3.78, 0.5)) for place in places]
    write_table(folder / "gps.dat", np.column_stack([begin + fixes, antenna]).tolist())
    rows = []
    for time in np.arange(0.1, seconds - 0.1, 0.2137):
        car = Pose.from_array(circle(start, speed, turn, np.array([time]))[0])
        for tree in TREES:
            ahead, left = Pose(3.78, 0.5, 0.0).inverse().transform(car.inverse().transform(tree))
            if ahead > 0.0:  # The scanner counts from its right.
                rows.append([begin + time, np.hypot(ahead, left), np.arctan2(left, ahead) + np.pi / 2, 0.3])
    write_table(folder / "measurements.dat", rows)
    return start


def run_command(*words: object) -> int:
    with pytest.raises(SystemExit) as end:
        main([str(word) for word in words])
    return int(end.value.code or 0)


def imported(source: Path, *, wishes: Wishes | None = None, record: Path | None = None) -> Recording:
    """Import a log in this process, as `mjsim.import_log` does in a child."""
    return recorded(lambda output: convert(Path(source), wishes or Wishes(), output), record=record)
