"""The controllers of one robot, by part."""

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from mjsim.errors import UsageError, did_you_mean
from mjsim.interface import Controller, ControlLoop, RobotInfo
from mjsim.modules import make_module
from mjsim.sentences import Sentence
from mjsim.sim.bases import RunningGear
from mjsim.sim.control_loop import ControlActuation, DrivenPart
from mjsim.sim.fast_senses import FastSenses, ImuFeed, JointEncoders
from mjsim.sim.sensors import FastDevice
from mjsim.world import Robot, Use, World

if TYPE_CHECKING:
    from mjsim.sim.arm_motion import ArmAtWork

OF_ARMS = "mjsim.algorithms.arm_control:PdGravity"
"""The default controller of arms."""


class Controls:
    """The controllers of a robot's parts between ticks; parts without one have a default."""

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        robot: Robot,
        *,
        gear: RunningGear,
        arms: "Sequence[ArmAtWork]",
        imus: Sequence[FastDevice],
        world: World,
        seed: int,
    ) -> None:
        """Find the parts; controllers are created later.

        Args:
            model: The compiled world.
            data: Its state.
            robot: Robot of the world file.
            gear: Its running gear, which may need a controller.
            arms: Its arms, each of which has one.
            imus: Its inertial sensors.
            world: Location for the search of controllers.
            seed: Seed of the run.
        """
        self._model, self._data, self._robot, self._world, self._seed = model, data, robot, world, seed
        self._feed, self._arms = ImuFeed(imus), arms
        self._wheels = [f"{robot.name}/{name}" for name in gear.wheels]
        self._parts = {part.name: part for part in self._found(gear)}
        self._running: dict[str, ControlActuation] = {}

    def actuations(self, info: RobotInfo) -> list[ControlActuation]:
        """Return the started controllers of all parts; `info` is the data sheet of the robot."""
        for name, part in self._parts.items():
            if name not in self._running:
                self._running[name] = self._started(part, part.default(), info)
        return list(self._running.values())

    def install(self, controllers: Mapping[str, Controller | ControlLoop], info: RobotInfo) -> None:
        """Start controllers, replacing those of their parts.

        Raises:
            UsageError: The part does not exist, or a rate is invalid.
            ModuleFault: A controller lacks a method, or raises when it starts.
        """
        for name, control in controllers.items():
            if name not in self._parts:
                raise UsageError(
                    Sentence(
                        "no part '{name}' of robot '{other_name}' for a controller{did_you_mean}",
                        name,
                        self._robot.name,
                        did_you_mean(name, self._parts),
                    )
                )
            loop = control if isinstance(control, ControlLoop) else ControlLoop(controller=control)
            self._running[name] = self._started(self._parts[name], loop, info)

    def feel(self, stamp: float) -> None:
        """Read the inertial sensors for controllers, at the end of a tick before modules read them [s]."""
        if self._running:
            self._feed.pull(stamp)

    def times(self) -> dict[str, float]:
        """Return the wall-clock time inside each controller since the last call, by part [s]."""
        return {name: actuation.seconds() for name, actuation in self._running.items()}

    def _started(self, part: DrivenPart, loop: ControlLoop, info: RobotInfo) -> ControlActuation:
        actuation = ControlActuation(self._model, self._data, part, loop=loop)
        rng = np.random.default_rng([self._seed, *f"{self._robot.name}/{part.name}/controller".encode()])
        actuation.start(info, rng)
        return actuation

    def _found(self, gear: RunningGear) -> list[DrivenPart]:
        """Return the parts of the robot that have a controller."""
        use, robot = self._robot.drive.controller, self._robot.name
        parts = [
            DrivenPart(
                robot=robot,
                name=arm.name,
                motors=arm.motors,
                wanted=arm.wanted,
                senses=self._senses,
                default=self._default(OF_ARMS),
            )
            for arm in self._arms
        ]
        if gear.wanted is None or use is None:
            return parts
        default, wheels = self._default(use), gear.wheels
        drive = DrivenPart(
            robot=robot, name="drive", motors=wheels, wanted=gear.wanted, senses=self._senses, default=default
        )
        return [drive, *parts]

    def _default(self, use: str) -> Callable[[], ControlLoop]:
        """Return the factory of a controller that comes with mjsim."""

        def make() -> ControlLoop:
            source, robot = self._world.source, self._robot.name
            return ControlLoop(controller=make_module(Use(use=use), source, role="controller", robot=robot))

        return make

    def _senses(self) -> FastSenses:
        """Return new inputs for a controller of this robot."""
        ticks = self._robot.odometry.ticks
        step = None if ticks is None else 2.0 * np.pi / ticks
        wheels = JointEncoders(self._model, self._data, self._wheels, step=step)
        return FastSenses(wheels=wheels, arms={arm.name: arm.encoders() for arm in self._arms}, imu=self._feed)
