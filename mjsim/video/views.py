"""The pictures of a film in sequence: composed, only the plan, or the scene rendered in 3-D."""

from collections.abc import Iterator, Sequence
from itertools import groupby, repeat

import numpy as np

from mjsim.errors import UsageError, did_you_mean
from mjsim.geometry import Array
from mjsim.interface import Picture
from mjsim.record import Recording, logged_cameras
from mjsim.sentences import Sentence
from mjsim.sim import SEEN_FROM_OUTSIDE, Playback
from mjsim.video.arm_frame import ArmFrame
from mjsim.video.diagrams import DiagramFrame, some_of
from mjsim.video.film_frame import Frame, PlanFrame
from mjsim.video.moment import moments
from mjsim.video.oblique import standing_arms
from mjsim.video.picture_layout import HEIGHT, WIDTH
from mjsim.world import Camera, View

DIAGRAMS = "diagrams"
"""The view of all mechanisms as kinematic diagrams."""

POSTURE_COUNT = 100
"""Number of postures of each mechanism to which a view is scaled."""


def known_views(recording: Recording) -> list[str]:
    """Return the names of the views available for a recording."""
    return [
        *(["plan", "chase"] if recording.robots else []),
        "overview",
        *([DIAGRAMS] if recording.world.mechanisms else []),
        *("/".join(camera) for camera in recording.cameras()),
        *(f"{person.name}/{side}_eye" for person in recording.world.people for side in ("left", "right")),
    ]


def composed_pictures(recording: Recording, rows: Sequence[int], display: View) -> Iterator[Picture]:
    """Yield the plan with close-up, onboard picture and error at ascending rows of a recording."""
    if arms_alone(recording):
        yield from _of_arms(recording, rows)
    else:
        yield from _drawn(_composed(recording, display), recording, rows)


def plan_pictures(recording: Recording, rows: Sequence[int], display: View) -> Iterator[Picture]:
    """Yield the plan at ascending rows of a recording."""
    yield from _drawn(_plan(recording, display), recording, rows)


def composed_picture(recording: Recording, row: int, display: View) -> Picture:
    """Return the composed picture of a row of a recording."""
    if arms_alone(recording):
        return next(_of_arms(recording, [row]))
    return _last(_composed(recording, display), recording, row)


def plan_picture(recording: Recording, row: int, display: View) -> Picture:
    """Return the plan at a row of a recording."""
    return _last(_plan(recording, display), recording, row)


def arms_alone(recording: Recording) -> bool:
    """Return whether a film shows arms from the side: the robot that it shows is stationary and has an arm."""
    robot = first_robot(recording)
    return any(arm.robot.name == robot for arm in standing_arms(recording))


def _of_arms(recording: Recording, rows: Sequence[int]) -> Iterator[Picture]:
    frame = ArmFrame(recording)
    for row, moment in zip(rows, moments(recording, first_robot(recording), rows), strict=True):
        yield frame.draw(moment, row)


def _composed(recording: Recording, display: View) -> Frame:
    seconds = float(recording.time[-1]) + 1e-3
    robot = first_robot(recording)
    return Frame(recording.world, robot, display=display, seconds=seconds, reach=_reach(recording))


def _plan(recording: Recording, display: View) -> PlanFrame:
    return PlanFrame(recording.world, first_robot(recording), display=display, reach=_reach(recording))


def _last(frame: Frame | PlanFrame, recording: Recording, row: int) -> Picture:
    """Return a frame's picture of a row after all rows before it, of which only the paths are drawn."""
    *before, moment = moments(recording, first_robot(recording), range(row + 1))
    for each in (*before, moment):
        frame.add(each)
    return frame.draw(moment)


def scene_pictures(recording: Recording, rows: Sequence[int], view: str) -> Iterator[Picture]:
    """Yield the picture of a camera at rows of a recording, rendered from the recorded states.

    For a camera of a log, the pictures are the recorded ones.

    Args:
        recording: Recording with the states.
        rows: Rows to render.
        view: 'chase' (of the first robot), 'overview', 'ROBOT/CAMERA', 'PERSON/left_eye' or 'PERSON/right_eye'.

    Raises:
        UsageError: The view does not exist.
    """
    known = known_views(recording)
    if view not in known:
        raise UsageError(Sentence("no view '{view}' of this recording{did_you_mean}", view, did_you_mean(view, known)))
    robot, _, name = view.partition("/")
    if (robot, name) in logged_cameras(recording):
        yield from _logged_pictures(recording, rows, robot, name)
        return
    camera = f"{first_robot(recording)}/chase" if view == "chase" else view
    sensor = _sensor(recording, view)
    if sensor is None:
        playback = Playback(
            recording.world,
            width=WIDTH,
            height=HEIGHT,
            quality=recording.world.run.view.quality,
            groups=SEEN_FROM_OUTSIDE,
            events=recording.events,
        )
    else:
        playback = Playback(
            recording.world,
            width=sensor.width,
            height=sensor.height,
            quality=sensor.quality,
            events=recording.events,
        )
    with playback:
        if view == "overview" and len(reach := _mechanisms_reach(recording)):
            playback.widen(np.array([reach.min(axis=0), reach.max(axis=0)]))
        picture: Picture | None = None
        for row in rows:
            picture = playback.picture(recording.qpos[row], camera, picture, time=recording.time[row])
            yield picture


def diagram_pictures(recording: Recording, rows: Sequence[int]) -> Iterator[Picture]:
    """Yield kinematic diagrams of all mechanisms at rows of a recording."""
    motions = {item.name: recording.joints[item.name].positions for item in recording.world.mechanisms}
    frame = DiagramFrame(recording.world, motions)
    for row in rows:
        yield frame.draw(float(recording.time[row]), {name: values[row] for name, values in motions.items()})


def _logged_pictures(recording: Recording, rows: Sequence[int], robot: str, camera: str) -> Iterator[Picture]:
    """Yield the newest picture of a log's camera at ascending rows of a recording; black before the first."""
    intrinsics = logged_cameras(recording)[robot, camera].intrinsics
    shown: Picture = np.zeros((intrinsics.height, intrinsics.width, 3), dtype=np.uint8)
    pictures = recording.images(robot, camera)
    stamp, following = next(pictures, (np.inf, shown))
    for row in rows:
        while stamp <= recording.time[row] + 1e-9:
            shown = following
            stamp, following = next(pictures, (np.inf, shown))
        yield shown


def _drawn(frame: Frame | PlanFrame, recording: Recording, rows: Sequence[int]) -> Iterator[Picture]:
    """Yield the picture of each row of a frame; consecutive equal rows are drawn once."""
    times = [(row, len(list(same))) for row, same in groupby(rows)]
    unique = [row for row, _ in times]
    for (_, count), moment in zip(times, moments(recording, first_robot(recording), unique), strict=True):
        frame.add(moment)
        yield from repeat(frame.draw(moment), count)


def first_robot(recording: Recording) -> str:
    """Return the first robot with a driver; without any, the first robot."""
    if not recording.robots:
        raise UsageError(Sentence("no robot in {path}; there is nothing to show", recording.path))
    driven = (name for name, track in recording.robots.items() if np.isfinite(track.estimate).all(axis=1).any())
    return next(driven, next(iter(recording.robots)))


def _reach(recording: Recording) -> Array:
    """Return the true positions of robots, shape (n, 2) [m]; estimated ones for robots without ground truth."""
    paths = []
    for track in recording.robots.values():
        known = [places[np.isfinite(places).all(axis=1), :2] for places in (track.truth, track.odometry)]
        paths.append(known[0] if len(known[0]) else known[1])
    return np.concatenate([*paths, _mechanisms_reach(recording)[:, :2]])


def _mechanisms_reach(recording: Recording) -> Array:
    """Return corners of boxes around mechanisms during their motion, world frame, shape (n, 3) [m]."""
    corners = [np.zeros((0, 3))]
    for item in recording.world.mechanisms:
        corners += [item.spanned(values) for values in some_of(recording.joints[item.name].positions, POSTURE_COUNT)]
    return np.concatenate(corners)


def _sensor(recording: Recording, view: str) -> Camera | None:
    """Return the onboard camera that a view names; None if it names none."""
    sensors = ((robot.name, sensor) for robot in recording.world.robots for sensor in robot.sensors)
    return {f"{robot}/{sensor.camera}": sensor for robot, sensor in sensors if isinstance(sensor, Camera)}.get(view)
