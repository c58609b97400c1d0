"""What a valid world leaves to defaults that decide results."""

from functools import partial

from mjsim.errors import Problem
from mjsim.world.items import Robot, World
from mjsim.world.yaml import problems_at


def world_notes(world: World) -> list[Problem]:
    """Return notes on behaviour that a user may not expect, sorted by position; none is an error."""
    faults = (
        (("robots", index, "name"), partial(str, message))
        for index, robot in enumerate(world.robots)
        if (message := usual_noise(robot)) is not None
    )
    return sorted(problems_at(world.source.written, world.source.file, faults))


def usual_noise(robot: Robot) -> str | None:
    """Return that a robot has the default noise of odometry, since none is given; None otherwise."""
    if robot.base == "fixed" or "noise" in robot.odometry.model_fields_set:
        return None
    noise = robot.odometry.noise
    return (
        f"robot '{robot.name}' names no odometry noise, so it has the usual one, distance {noise.distance:g} m/sqrt(m)"
        f" and turn {noise.turn:g} rad/sqrt(rad); odometry: {{noise: {{distance: 0, turn: 0}}}} has none"
    )
