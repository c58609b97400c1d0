"""Controllers of mechanisms: modules that compute torques or forces on joints between ticks."""

from collections.abc import Callable, Sequence

import mujoco
import numpy as np

from mjsim.geometry import Pose
from mjsim.interface import Command, ControlLoop, JointGoal, RobotInfo
from mjsim.mechanics import Constant, TimeSignal
from mjsim.modules import Hosted, make_module
from mjsim.sim.control_loop import ControlActuation, DrivenPart
from mjsim.sim.fast_senses import FastSenses, ImuFeed, JointEncoders
from mjsim.sim.streams import stream
from mjsim.world import Control, ForceActuator, Mechanism, TorqueActuator, World


class MechanismControls:
    """The running controllers of one mechanism, each called at its own rate."""

    def __init__(
        self, model: mujoco.MjModel, data: mujoco.MjData, mechanism: Mechanism, *, world: World, seed: int
    ) -> None:
        """Create and start the modules.

        Args:
            model: The compiled world.
            data: Its state at the start.
            mechanism: The mechanism to control.
            world: The world, for the search path of modules and the files of signals.
            seed: Seed of the run.

        Raises:
            UsageError: A module does not exist or refuses its keys, or a rate does not fit.
            ModuleFault: A module fails, or lacks a method that controllers need.
        """
        self._model, self._data, self._mechanism = model, data, mechanism
        self._world, self._seed = world, seed
        self._modules: list[object] = []
        found = [each for each in mechanism.actuators if isinstance(each, TorqueActuator | ForceActuator)]
        try:
            self.actuations = [self._started(each, each.controller) for each in found if each.controller is not None]
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Close the modules that hold more than memory."""
        for module in self._modules:
            if isinstance(module, Hosted):
                module.close()

    def _started(self, actuator: TorqueActuator | ForceActuator, control: Control) -> ControlActuation:
        name = self._mechanism.name
        module = make_module(control, self._world.source, role="controller", robot=name)
        self._modules.append(module)
        loop = ControlLoop(controller=module, rate_hz=control.rate_hz, latency=control.latency)
        part = DrivenPart(
            robot=name,
            name=actuator.target,
            motors=(actuator.target,),
            wanted=self._wanted(actuator),
            senses=self._senses,
            default=lambda: loop,
        )
        actuation = ControlActuation(self._model, self._data, part, loop=loop)
        actuation.start(self._robot_info(), stream(self._seed, name, f"{actuator.target}/controller"))
        return actuation

    def _wanted(self, actuator: TorqueActuator | ForceActuator) -> Callable[[float], Command]:
        """Return a function for the current goal of a joint [rad, m]."""
        assembly, target = self._mechanism.assembly, actuator.target
        column = assembly.column(target)
        signal: TimeSignal = Constant(level=float(assembly.start[column]))
        if actuator.goal is not None:
            rng = stream(self._seed, self._mechanism.name, f"{target}/goal")
            signal = actuator.goal.made(self._world.read_asset, rng, angle=not assembly.slides[column])

        def wanted(dt: float) -> Command:
            time = float(self._data.time)
            goal = JointGoal(positions=(float(signal.value(time)),), velocities=(float(signal.rate(time)),))
            return Command(joints={target: goal})

        return wanted

    def _senses(self) -> FastSenses:
        """Return the inputs of a controller: each joint coordinate by the name of its joint, or by `JOINT.VALUE`."""
        names = {self._model.joint(number).name for number in range(self._model.njnt)}
        full = {value: f"{self._mechanism.name}/{value}" for value in self._mechanism.assembly.names}
        arms = {value: self._encoders([name]) for value, name in full.items() if name in names}
        return FastSenses(wheels=self._encoders([]), arms=arms, imu=ImuFeed([]))

    def _encoders(self, joints: Sequence[str]) -> JointEncoders:
        return JointEncoders(self._model, self._data, joints)

    def _robot_info(self) -> RobotInfo:
        """Return the description of the mechanism for a module: its pose and its name."""
        x, y = self._mechanism.at
        return RobotInfo(
            name=self._mechanism.name,
            drive="fixed",
            max_speed=0.0,
            max_turn=0.0,
            max_acceleration=0.0,
            max_turn_acceleration=0.0,
            wheels=(),
            wheel_radius=0.0,
            track=0.0,
            radius=0.0,
            dt=self._world.run.steps_per_tick * self._model.opt.timestep,
            prior=Pose(x, y, float(np.radians(self._mechanism.heading_deg))),
            prior_covariance=np.zeros((3, 3)),
        )
