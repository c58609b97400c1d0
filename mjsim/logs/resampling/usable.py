"""Selects the part of a log that can be recorded."""

from dataclasses import replace
from pathlib import Path

from mjsim.errors import MAX_MESSAGE_LENGTH, UsageError
from mjsim.inventory import Fate
from mjsim.logs.resampling.log import Log

MIN_PICTURE_SIDE, MAX_PICTURE_SIDE = 16, 4096
"""Limits of width and height of pictures in a recording [px]."""


def usable(log: Log) -> Log:
    """Return a log without the cameras whose pictures are too small or too large, which its notes name."""
    limits = f"{MIN_PICTURE_SIDE} to {MAX_PICTURE_SIDE}"
    wrong = {
        name: f"pictures of {size.width} x {size.height} pixels; a camera has {limits} to each side"
        for name, size in ((name, camera.intrinsics) for name, camera in log.cameras.items())
        if not all(MIN_PICTURE_SIDE <= side <= MAX_PICTURE_SIDE for side in (size.width, size.height))
    }
    if not wrong:
        return log
    frames = {name: frames for name, frames in log.robot.cameras.items() if name not in wrong}
    return replace(
        log,
        robot=replace(log.robot, cameras=frames),
        cameras={name: camera for name, camera in log.cameras.items() if name not in wrong},
        notes={**log.notes, **{f"{name} left out": why for name, why in wrong.items()}},
    )


def require_motion(log: Log, source: Path) -> None:
    """Check that a log contains motion or sensor data."""
    robot = log.robot
    if (
        robot.track is None
        and not len(robot.twists)
        and not any((robot.scans, robot.cameras, robot.clouds, robot.sightings, robot.imu))
    ):
        unread = ", ".join(
            f"{fact}: {count}" for fact, count in log.notes.items() if fact.endswith(Fate.LEFT_OUT) and count != "0"
        )
        raise UsageError(
            f"'{source}' holds no odometry, scans, clouds, pictures, IMU or sightings; {instead_of_log(source, unread)}"
            f"{f' ({unread})' if unread else ''}"[:MAX_MESSAGE_LENGTH]
        )


def instead_of_log(source: str | Path, types: str) -> str:
    """Return what to do with a bag that holds messages of these types, but nothing to record."""
    if "geometry_msgs/msg/Pose" in types or "nav_msgs/msg/Path" in types:
        return f"evaluate its poses with mjsim replay RUN.mcap --trajectory '{source}'"
    return "there is nothing to record"
