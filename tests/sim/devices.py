"""Sensors without the loop around them: read as often as a test asks, while the physics stands still."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from mjsim.sim import Simulation
from mjsim.sim.bases import gear_of
from mjsim.sim.sensors import MAKERS, Mounting
from mjsim.sim.sensors.device import Device
from mjsim.sim.streams import cached, streams_of
from mjsim.world import name_of


def device_of(sim: Simulation, number: int = 0, *, seed: int = 0) -> Device:
    """Return a device like that of one sensor of the first robot, with random streams of its own."""
    robot = sim.world.robots[0]
    sensor = robot.sensors[number]
    mounting = Mounting(
        model=sim.model,
        data=sim.data,
        robot=robot,
        gear=gear_of(robot, dt=sim.dt, seed=seed, source=sim.world.source, clock=lambda: 0.0),
        beacons=sim.world.beacons,
        streams=cached(streams_of(seed, robot.name, name_of(sensor))),
        canvas=_none,
    )
    return MAKERS[type(sensor)](sensor, mounting)


def _none(_: object) -> Any:
    raise AssertionError("cameras need the renderers of a simulation")


def taken(sim: Simulation, count: int, *, seed: int = 0) -> Iterator[Any]:
    """Yield readings of the first sensor of the first robot, all at one place."""
    device = device_of(sim, seed=seed)
    return (device.take(float(number)) for number in range(count))


def moved(sim: Simulation, *, rotation: Any, velocity: Any, turn: Any) -> None:
    """Set orientation, velocity in the world [m/s] and turn in its own frame [rad/s] of the first robot's base."""
    free = sim.model.joint(f"{sim.world.robots[0].name}/free")
    place, speed = int(free.qposadr[0]), int(free.dofadr[0])
    x, y, z, w = rotation.as_quat()
    sim.data.qpos[place + 3 : place + 7] = w, x, y, z
    sim.data.qvel[speed : speed + 6] = np.concatenate([velocity, turn])
