"""Notes on a valid world: defaults that decide results, starts outside the walls, and corrected files of arms."""

from collections.abc import Iterator
from functools import partial

import numpy as np

from mjsim.errors import Problem
from mjsim.geometry import Array
from mjsim.sentences import Sentence
from mjsim.world.check.overlaps import pair
from mjsim.world.items import Camera, Photons, Robot, World
from mjsim.world.yaml import problems_at


def world_notes(world: World) -> list[Problem]:
    """Return notes on behaviour that a user may not expect, sorted by position; none is an error."""
    faults = [(place, partial(str, message)) for place, message in _usual(world)]
    return sorted(problems_at(world.source.written, world.source.file, faults))


def _usual(world: World) -> Iterator[tuple[tuple[str | int, ...], str]]:
    """Yield notes on default noise, starts outside the walls, and differences from the files of arms."""
    corners = [point for wall in world.walls for point in wall.points]
    for index, robot in enumerate(world.robots):
        if corners and (message := starts_outside(robot, np.array(corners))) is not None:
            yield ("robots", index, "at"), message
        if (message := usual_noise(robot)) is not None:
            yield ("robots", index, "name"), message
        for number, sensor in enumerate(robot.sensors):
            if isinstance(sensor, Camera) and (message := usual_photons(robot, sensor)) is not None:
                yield ("robots", index, "sensors", number, "camera"), message
        for number, arm in enumerate(robot.arms):
            for note in arm.file_arm.changed if arm.model is not None else ():
                yield ("robots", index, "arms", number, "model"), f"arm '{robot.name}/{arm.name}': {note}"


def starts_outside(robot: Robot, corners: Array) -> str | None:
    """Return a note that a robot starts outside walls with these corners, shape (n, 2) [m]; None otherwise."""
    low, high = corners.min(axis=0), corners.max(axis=0)
    has_room = (high - low > 2.0 * robot.body.radius).all()  # between them; in front of one straight wall there is none
    if not has_room or ((low <= robot.at) & (robot.at <= high)).all():
        return None
    return Sentence(
        "robot '{name}' at {at} starts outside the walls, which reach from {low} to {high}",
        *(robot.name, pair(robot.at), pair(low), pair(high)),
    )


def usual_photons(robot: Robot, camera: Camera) -> str | None:
    """Return a note that a camera has the default noise, since none is given; None otherwise."""
    if "noise" in camera.model_fields_set or not isinstance(camera.noise, Photons):
        return None
    return Sentence(
        "camera '{name}/{camera}' has no key noise, so it has the default, full well {full_well:g} and"
        " read-out {read:g} electrons; for none, write noise: 0",
        *(robot.name, camera.camera, camera.noise.full_well, camera.noise.read),
    )


def usual_noise(robot: Robot) -> str | None:
    """Return a note that a robot has the default noise of odometry, since none is given; None otherwise."""
    if robot.base == "fixed" or "noise" in robot.odometry.model_fields_set:
        return None
    noise = robot.odometry.noise
    return Sentence(
        "robot '{name}' has no odometry noise, so it has the default, distance {distance:g} m/sqrt(m)"
        " and turn {turn:g} rad/sqrt(rad); for none, write odometry: {{noise: {{distance: 0, turn: 0}}}}",
        *(robot.name, noise.distance, noise.turn),
    )
