"""Trajectories of other programs as estimates: files of TUM, EuRoC, KITTI and g2o, or poses in a bag of ROS."""

import math
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
from numpy.random import Generator

from mjsim.errors import UsageError
from mjsim.geometry import Array, Pose, headings, places_at
from mjsim.guarded import Plain, guarded
from mjsim.interface import BeaconInfo, Estimate, Observation, RobotInfo
from mjsim.inventory import Fate, told
from mjsim.logs.bags import POSES, Bag, is_bag, pose_of
from mjsim.logs.files import MAX_NUMBER, lines_of
from mjsim.logs.importing import readable_folders
from mjsim.logs.named_poses import in_seconds, named_rows
from mjsim.record import Recording

ODOMETRY_TYPES, PATH_TYPES = "nav_msgs/msg/Odometry", "nav_msgs/msg/Path"
TYPES = (*(kind for kind in POSES if "Transform" not in kind), ODOMETRY_TYPES, PATH_TYPES)
"""Types of messages with poses of a robot."""
VERTICES, KITTI_NUMBERS = {"VERTEX_SE2": 4, "VERTEX_SE3:QUAT": 8}, 12
"""Numbers after the names of vertices of g2o that are poses, and in a row of KITTI."""
EUROC_COLUMNS, MIN_NANOSECONDS = (8, 17), 1e15
"""Numbers in a row of EuRoC: time, position, quaternion with w first, and perhaps velocity and biases; and the smallest
time that is in nanoseconds. A comment with `[ns]` says that they are from the beginning."""
NO_VERTICES = ("FIX", "VERTEX_XY", "VERTEX_TRACKXYZ")
"""Names of other lines of g2o; those of edges and parameters begin alike."""
MAX_ROWS = 5_000_000
MAX_LATE_SECONDS = 5.0
"""Maximum time by which a trajectory may begin after a run [s]."""
MAX_SILENT_SECONDS, MAX_STEPS = 1.0, 5.0
"""A gap without poses is reported beyond these: absolute [s], and as a multiple of the usual time between two."""


def read_trajectory(
    path: str | Path, *, topic: str | None = None, period: float | None = None, notes: dict[str, str] | None = None
) -> Array:
    """Return the planar poses in a file: rows of time [s], x, y [m] and heading [rad], in order of time.

    Args:
        path: A text file with rows `t x y z qx qy qz qw` (TUM) or `t x y heading`, a table with names of columns in any
            order, a ground truth of EuRoC, poses of a camera or a robot as in KITTI, or vertices of g2o; or a bag of
            ROS.
        topic: The topic of a bag; by default its only one with poses.
        period: Time from one pose to the next, in files without times: KITTI and g2o [s].
        notes: Notes on how the file was interpreted, as in the metadata of a recording; this adds to them.

    Raises:
        UsageError: The file cannot be read, has no poses, or several topics with poses.
    """
    path = Path(path)
    if not path.exists():
        raise UsageError(f"no file '{path}'; name a trajectory: rows t x y z qx qy qz qw, or a bag of ROS with poses")
    found = guarded(f"{__name__}:trajectory_rows", path, topic, period, about=path, folders=readable_folders(path))
    told_of = {str(fact): str(value) for fact, value in found["notes"].items()}
    if notes is not None:
        notes |= told_of
    rows = np.asarray(found["rows"], dtype=float).reshape(-1, 4)
    # Of several poses at one time the last one counts: that of the newest path.
    rows = rows[::-1]
    _, last = np.unique(rows[:, 0], return_index=True)
    if len(last) < 2:
        raise UsageError(f"'{path}' has {len(last)} poses at different times; a trajectory has at least two")
    return np.asarray(rows[last])


def trajectory_rows(path: Path, topic: str | None, period: float | None = None) -> Mapping[str, Plain]:
    """Return the rows of `read_trajectory` as they are in the file, and its notes; called in the guarded reader."""
    is_of_ros = is_bag(path)
    if topic is not None and not is_of_ros:
        raise UsageError(f"'{path}' is not a ROS bag, so it has no topics; leave out topic")
    notes: dict[str, str] = {}
    if not is_of_ros and (named := named_rows(path, notes)) is not None:
        return {"rows": named, "notes": notes}
    found = _rows_of_bag(path, topic) if is_of_ros else _rows_of_text(path, period)
    rows = np.array([row for row, _ in zip(found, range(MAX_ROWS), strict=False)]).reshape(-1, 4)
    if not is_of_ros:
        rows[:, 0] = in_seconds(rows[:, 0], notes)
    return {"rows": rows, "notes": notes}


def _rows_of_text(path: Path, period: float | None) -> Iterator[tuple[float, float, float, float]]:
    earliest_ns = MIN_NANOSECONDS
    of_kitti: list[list[float]] = []
    for number, line in enumerate(lines_of(path, {}), start=1):
        # Where semicolons separate numbers, as in tables of half of Europe, commas are decimal.
        words = (line.replace(",", ".").replace(";", " ") if ";" in line else line.replace(",", " ")).split()
        if not words or line.lstrip().startswith(("#", "%")):
            earliest_ns = 0.0 if "[ns]" in line else earliest_ns
            continue
        if words[0] in NO_VERTICES or words[0].startswith(("EDGE_", "PARAMS_")):
            continue
        kind = words[0] if words[0] in VERTICES else None
        try:
            values = [float(word) for word in words[1 if kind else 0 :]]
        except ValueError:
            values = []
        if len(values) == (VERTICES[kind] if kind else KITTI_NUMBERS) and all(
            abs(value) <= MAX_NUMBER for value in values
        ):
            if period is None:
                raise UsageError(
                    f"{path}:{number}: its poses have no times; give period, the seconds between two poses"
                )
            if kind:
                yield _of_vertex(values, period)
            elif len(of_kitti) < MAX_ROWS:
                of_kitti.append(values)
            continue
        if len(values) in EUROC_COLUMNS and earliest_ns <= values[0] <= 1e9 * MAX_NUMBER:
            time, x, y, z, *turned = values[:8]
            # Only EuRoC, whose columns have commas, writes w first.
            values = [1e-9 * time, x, y, z, *(turned[1:] + turned[:1] if "," in line and ";" not in line else turned)]
        if len(values) not in (4, 8) or not all(abs(value) <= MAX_NUMBER for value in values):
            raise UsageError(
                f"{path}:{number}: '{line.strip():.60}' is not a pose; write t x y z qx qy qz qw, or t x y heading"
            )
        if not any(values[4:]) and len(values) == 8:
            raise UsageError(
                f"{path}:{number}: '{line.strip():.60}' has a quaternion of length 0; without headings, write 0 0 0 1"
            )
        yield values[0], values[1], values[2], values[3] if len(values) == 4 else float(headings(values[4:]))
    if of_kitti and period is not None:
        yield from _of_kitti(of_kitti, period)


def _of_vertex(values: list[float], period: float) -> tuple[float, float, float, float]:
    """Return the row of a vertex of g2o, at the time of its number."""
    turn = values[3] if len(values) == VERTICES["VERTEX_SE2"] else float(headings(values[4:]))
    return values[0] * period, values[1], values[2], turn


def _of_kitti(rows: list[list[float]], period: float) -> Iterator[tuple[float, float, float, float]]:
    """Yield the rows of poses of KITTI in the order of the file.

    A camera looks along z, with x to its right; its first pose is the origin of the file. Other programs write poses of
    a robot, with z up: then it moves less along z than along y.
    """
    poses = np.array(rows).reshape(-1, 3, 4)
    _, y, z = np.ptp(poses[:, :, 3], axis=0)
    for index, pose in enumerate(poses.tolist()):
        ahead, left, turn = (
            (pose[0][3], pose[1][3], math.atan2(pose[1][0], pose[0][0]))
            if z <= y
            else (pose[2][3], -pose[0][3], math.atan2(-pose[0][2], pose[2][2]))
        )
        yield index * period, ahead, left, turn


def _rows_of_bag(path: Path, topic: str | None) -> Iterator[tuple[float, float, float, float]]:
    with Bag(path) as bag:
        posed = {name: kind for name, kind in bag.types.items() if kind in TYPES}
        chosen = posed if topic is None else {name: kind for name, kind in posed.items() if name == topic}
        if not posed:
            raise UsageError(f"'{path}' has no topic with poses of a robot; it needs one of {', '.join(TYPES)}")
        if len(chosen) != 1:
            raise UsageError(
                f"'{path}' has {len(posed)} topics with poses ({', '.join(sorted(posed))[:300]});"
                " name one of them with topic"
            )
        ((name, kind),) = chosen.items()
        for message in bag.messages([name]):
            decoded = bag.decode(message)
            # The last path is the final one.
            for each in decoded.poses if kind == PATH_TYPES else (decoded,):
                stamp = each.header.stamp
                pose = pose_of(each)
                time = float(stamp.sec) + 1e-9 * float(stamp.nanosec)
                yield time, float(pose[0, 3]), float(pose[1, 3]), math.atan2(pose[1, 0], pose[0, 0])


def offset_to_run(
    path: str | Path,
    run: Recording,
    *,
    topic: str | None = None,
    period: float | None = None,
    offset: float | None = None,
    notes: dict[str, str],
) -> float:
    """Return the offset from the times of a trajectory to those of a run [s].

    Trajectories made from a log of a real robot have its clock, while the recording of the log begins at 0.

    Args:
        path: The trajectory; topic, period and notes as for `read_trajectory`.
        run: The recording that it is evaluated on.
        topic: Topic of a bag.
        period: Time between poses without times [s].
        offset: The user's offset.
        notes: Notes on how the file was interpreted, and where poses are missing.

    Raises:
        UsageError: It cannot be read, or has no pose at the beginning of the run.
    """
    times = read_trajectory(path, topic=topic, period=period, notes=notes)[:, 0]
    if offset is None:
        started = float(run.metadata.get("log start", 0.0))
        offset = -started if abs(times[0] - started) < abs(times[0]) else 0.0
    begins, ends = run.time[[0, -1]].tolist()
    if problem := _misfit(path, times, offset, begins):
        raise UsageError(problem)
    for fact, missing in (
        ("before the first", times[0] + offset - begins),
        ("after the last", ends - times[-1] - offset),
    ):
        if missing > MAX_SILENT_SECONDS:
            notes[f"pose {fact} of the trajectory"] = told(Fate.GUESSED, f"it stays the same for {missing:.1f} s")
    steps = np.diff(times)
    if steps.max() > max(MAX_SILENT_SECONDS, MAX_STEPS * float(np.median(steps))):
        at = times[int(np.argmax(steps))] + offset
        notes["poses in gaps of the trajectory"] = told(
            Fate.GUESSED, f"interpolated; the longest gap is {steps.max():.1f} s, from {at:.1f} s"
        )
    return offset


def _misfit(file: str | Path, times: Array, offset: float, now: float) -> str:
    """Return why a trajectory has no pose at a time of a run, or ''; the offset is not yet added to its times."""
    begins, ends = times[[0, -1]].tolist()
    if begins + offset - MAX_LATE_SECONDS <= now < ends + offset:
        return ""
    return (
        f"'{file}' has poses from {begins:.3f} to {ends:.3f} s; with {offset:.3f} s added, no pose is at {now:.3f} s of"
        " the run: give another offset"
    )


class Trajectory:
    """An estimator that gives the poses in a file of another program, interpolated, for `report` and `compare`.

    Its covariances are zero, as such files have none: the NEES is left out.
    """

    def __init__(
        self,
        file: str,
        *,
        topic: str | None = None,
        offset: float = 0.0,
        frame: str = "start",
        period: float | None = None,
    ) -> None:
        """Read the file.

        Args:
            file: See `read_trajectory`.
            topic: The topic of a bag.
            offset: Added to the times in the file, to get those of the run [s].
            frame: 'start': its first pose in the run is where the robot starts; 'world': poses are in the world frame.
            period: See `read_trajectory`.
        """
        if frame not in ("start", "world"):
            raise ValueError(f"frame is '{frame:.40}'; it must be start or world")
        self._track = read_trajectory(file, topic=topic, period=period)
        self._track[:, 0] += offset
        self._offset = offset
        self._file, self._anchored = file, frame == "start"
        self._world_from_file: Pose | None = None
        self._prior = Pose(0.0, 0.0, 0.0)

    def start(self, robot: RobotInfo, catalogue: Mapping[str, BeaconInfo], rng: Generator) -> None:
        """Remember where the robot starts."""
        self._prior = robot.prior

    def update(self, seen: Observation) -> Estimate:
        """Return the pose at the time of an observation; beyond the ends, the first or the last one.

        Raises:
            UsageError: As in `require_pose_at`.
        """
        if self._world_from_file is None:
            self.require_pose_at(seen.time)
            first = self._at(seen.time)
            self._world_from_file = self._prior @ first.inverse() if self._anchored else Pose(0.0, 0.0, 0.0)
        return Estimate(self._world_from_file @ self._at(seen.time), np.zeros((3, 3)))

    def require_pose_at(self, time: float) -> None:
        """Check that the trajectory covers the time at which a run begins [s].

        Raises:
            UsageError: It does not.
        """
        if problem := _misfit(self._file, self._track[:, 0] - self._offset, self._offset, time):
            raise UsageError(problem)

    def _at(self, time: float) -> Pose:
        moment = np.clip([time], self._track[0, 0], self._track[-1, 0])
        return Pose.from_array(places_at(moment, self._track, gap=math.inf)[0])
