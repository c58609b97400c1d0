"""The simulation of a world in MuJoCo."""

import math
import weakref
from collections.abc import Mapping, Sequence
from functools import partial
from itertools import chain
from pathlib import Path
from types import MappingProxyType

import mujoco

from mjsim.closing import Closes
from mjsim.compile import compile_world, compiled
from mjsim.errors import PhysicsFault, UsageError, did_you_mean
from mjsim.geometry import Array, Pose, Pose3
from mjsim.interface import (
    BeaconInfo,
    Command,
    Controller,
    ControlLoop,
    Observation,
    Odometry,
    RobotInfo,
    WheelCommand,
    WorldMap,
)
from mjsim.mechanics import JointMotion, SensorReadings
from mjsim.sentences import Sentence
from mjsim.sim.actuation import Actuation
from mjsim.sim.bumper import Bumpers
from mjsim.sim.current_noise import Tuning
from mjsim.sim.health import Health, collected_warnings
from mjsim.sim.mechanisms import Mechanisms
from mjsim.sim.module_info import catalogue_of, map_of
from mjsim.sim.radio import RadioNet
from mjsim.sim.rendering import Canvases, Snapshot, light_source
from mjsim.sim.robot import SimulatedRobot
from mjsim.sim.script import WorldScript
from mjsim.sim.states import bring_up
from mjsim.sim.streams import checked_seed
from mjsim.views import Viewed
from mjsim.world import Looks, World, WorldEvent, event_from, load_checked, require_same_but_noise


class Simulation(Viewed, Closes):
    """A simulated world: sense, decide, apply, step.

    One tick is: `sense` every robot, run the modules, `apply` every command, `step`. Use it from one thread at a time,
    and close it (or use `with`) if cameras have been used.
    """

    def __init__(self, world: World | str | Path, *, seed: int | None = None) -> None:
        """Compile the world and put the robots at their starts.

        Args:
            world: The world to simulate, its file, or the name of a shipped world.
            seed: Seed of all random numbers in the run; by default that of the world.

        Raises:
            UsageError: The seed is negative, a camera's rate does not divide the loop's, or the world cannot compile.
            WorldError: The file is not a valid world.
        """
        world = world if isinstance(world, World) else load_checked(world)
        self.world = world
        self.seed = checked_seed(world.run.seed if seed is None else seed)
        self.model: mujoco.MjModel = compiled(compile_world(world))
        if world.mechanisms or any(robot.arms for robot in world.robots):
            from mjsim.compile import set_exact_masses

            set_exact_masses(self.model, world)
        self.data = mujoco.MjData(self.model)
        self.dt: float = world.run.steps_per_tick * self.model.opt.timestep
        """Period of the control loop [s]."""
        self.tick = 0
        """Ticks since the start."""
        self._compiled, self._light = Snapshot(self.model), light_source(world, self.model)
        self._canvases, self._health = Canvases(), Health(self.model, world)
        # Created at the first step, so that no default controller is made only to be replaced.
        self._actuations: list[Actuation] | None = None
        self._set_up()
        self.catalogue: Mapping[str, BeaconInfo] = MappingProxyType(catalogue_of(world))
        """Catalogue entry of each beacon, by name."""
        self.map: WorldMap | None = map_of(world) if world.run.map == "known" else None
        """The map that modules get; None if the world has `map: unknown`."""

    def reset(self, seed: int | None = None) -> None:
        """Return to the start: from then on, everything is byte for byte as in a new simulation with that seed.

        Nothing is compiled again, and cameras keep their renderers; `robots` is created again.

        Args:
            seed: Seed of all random numbers from now on; by default the same as before.

        Raises:
            UsageError: The seed is negative.
        """
        self.seed = checked_seed(self.seed if seed is None else seed)
        self._mechanisms.close()
        self._compiled.restore(self.model)
        mujoco.mj_resetData(self.model, self.data)
        self.tick = 0
        self._set_up()

    def retune(self, world: World) -> None:
        """Take the noise settings of another world for drives, odometry and sensors from now on; all else is unchanged.

        Random streams continue, and one that was not in use starts. The data sheets given to modules at the start do
        not change. `reset` keeps the new noise.

        Raises:
            UsageError: It differs in something else; the message names the first key.
        """
        require_same_but_noise(self.world, world)
        self.world = world
        self._tuning.take(world)

    @property
    def tuned(self) -> World:
        """The world with its current noise, after all events."""
        return self._tuning.world

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.tick * self.dt

    def sense(self, robot: str) -> Observation:
        """Return a robot's observation at this tick; computed once per tick, pictures only when due."""
        return self._robot(robot).sense(self.tick)

    def odometry(self, robot: str) -> Odometry:
        """Return the odometry increment of a robot at this tick, as `sense` does, without computing other readings."""
        return self._robot(robot).odometry

    def apply(self, robot: str, command: Command | WheelCommand) -> None:
        """Give a robot a command, which it follows within its limits until the next one.

        Raises:
            UsageError: The robot does not exist, the command is of the wrong kind or not finite, or a message cannot be
                sent.
        """
        self._robot(robot).command(command)
        try:
            self._radio.queue(robot, command.messages if isinstance(command, Command) else ())
        except ValueError as error:
            raise UsageError(Sentence("robot '{robot}' sends {error}", robot, error)) from None

    def control(self, robot: str, controllers: Mapping[str, Controller | ControlLoop]) -> None:
        """Set the controllers of parts of a robot until `reset`; other parts keep theirs.

        Args:
            robot: Name.
            controllers: By part, 'drive' of a balancing base or the name of an arm; at 250 Hz and without latency
                unless set by a `ControlLoop`.

        Raises:
            UsageError: The robot or part does not exist, or a rate is not a whole number of physics steps.
            ModuleFault: A controller lacks a method, or raises when it starts.
        """
        self._robot(robot).control(controllers)
        self._actuations = None

    def control_times(self, robot: str) -> dict[str, float]:
        """Return the wall-clock time inside each controller of a robot since the last call, by part [s]."""
        return self._robot(robot).control_times()

    def step(self) -> None:
        """Advance by one tick.

        Raises:
            PhysicsFault: MuJoCo warned, or the state is out of bounds; the message has the time.
        """
        self._radio.send(self.tick, self.time, self.truths)
        for robot in self._robots.values():
            robot.before_step(self.tick)
        messages = self._run_physics()
        self.tick += 1
        self._mechanisms.settle(self.tick)
        self._script.let_happen(self.time)
        self._refresh()
        loop = self._mechanisms.failing(self.tick, known=bool(self.data.warning.number.any()))
        if (failure := self._health.fault(self.data, messages, loop=loop)) is not None:
            raise PhysicsFault(Sentence("physics failed at {time:.2f} s: {failure}", self.time, failure))
        for robot in self._robots.values():
            robot.after_tick(self.tick)

    def truth(self, robot: str) -> Pose:
        """Return the true pose of a robot, seen from above, world frame."""
        return self._robot(robot).truth().planar()

    def truths(self) -> dict[str, Pose]:
        """Return the true pose of each robot, seen from above, world frame."""
        return {name: robot.truth().planar() for name, robot in self._robots.items()}

    def pose(self, robot: str) -> Array:
        """Return the true 3-D pose of a robot's base, world_from_base, shape (4, 4) [m].

        Raises:
            UsageError: The robot does not exist.
        """
        return self._robot(robot).truth().matrix()

    def poses(self) -> dict[str, Pose3]:
        """Return the true 3-D pose of each robot's base, world frame."""
        return {name: robot.truth() for name, robot in self._robots.items()}

    def motions(self) -> dict[str, JointMotion]:
        """Return the true motion of the joints of each arm and mechanism, by `ROBOT/ARM` and by name."""
        of_robots = ((f"{n}/{arm}", each) for n, robot in self._robots.items() for arm, each in robot.motions().items())
        return {**dict(of_robots), **self._mechanisms.motions(self.tick)}

    def readings(self) -> dict[str, SensorReadings]:
        """Return the current sensor readings of each mechanism."""
        return self._mechanisms.readings(self.tick)

    def identities(self, robot: str) -> tuple[str | None, ...]:
        """Return the true beacon of each sighting at this tick, None for a false one; modules do not get this."""
        return self._robot(robot).identities(self.tick)

    def move(self, name: str, pose: Pose, *, anywhere: bool = False) -> None:
        """Put a robot or a movable obstacle at rest at a pose; odometry does not measure the move.

        Raises:
            UsageError: The name does not exist, or the pose is out of bounds or in a wall or object and not `anywhere`.
        """
        keys: dict[str, object] = {"move": name, "to": (pose.x, pose.y), "heading_deg": math.degrees(pose.heading)}
        if not anywhere:  # There, contacts would throw it out in the next steps.
            self._script.require_room(event_from({"time": self.time, **keys}))
        self._happen(**keys)

    def open_door(self, name: str, angle: float = math.pi / 2) -> None:
        """Start to open a door to an angle, positive to the left of its wall [rad]; raises UsageError if it cannot."""
        self._happen(open=name, angle_deg=math.degrees(angle))

    def close_door(self, name: str) -> None:
        """Start to close a door; raises UsageError if it does not exist."""
        self._happen(close=name)

    def door_angle(self, name: str) -> float:
        """Return a door's angle, positive to the left side of its wall [rad]; raises UsageError if there is none."""
        return self._script.door(name)

    def set_light(self, level: float) -> None:
        """Set the ambient light; raises UsageError if it is out of bounds."""
        self._happen(light=level)

    def set_lamp(self, name: str, brightness: float) -> None:
        """Switch or dim a lamp, 0 is off; raises UsageError if there is none, or the brightness is out of bounds."""
        self._happen(lamp=name, brightness=brightness)

    def set_noise(self, key: str, value: float) -> None:
        """Change the noise of a sensor, a drive or odometry, as the event `noise` does.

        Raises:
            UsageError: There is no noise with this key (as for `--set`), or the value is invalid.
        """
        self._happen(noise=key, value=value)

    def remove(self, name: str) -> None:
        """Remove a beacon or an obstacle, with everything attached to it; raises UsageError if there is none."""
        self._happen(remove=name)

    def restore(self, name: str) -> None:
        """Restore a removed beacon or obstacle where it was; raises UsageError if there is none."""
        self._happen(restore=name)

    def shove(self, name: str, impulse: Sequence[float], seconds: float = 0.1) -> None:
        """Start to push a robot or a movable obstacle at its centre of mass.

        Args:
            name: Name of the robot or the obstacle.
            impulse: Total impulse in x, y and z, world frame [N s].
            seconds: Duration [s].

        Raises:
            UsageError: The name does not exist, or a number is out of bounds.
        """
        self._happen(shove=name, impulse=tuple(impulse), seconds=seconds)

    def reach(self, robot: str, keys: Mapping[str, object]) -> None:
        """Move an arm, in place of the goals in commands, or a person's hand, until `release`.

        Args:
            robot: Name of the robot or the person.
            keys: As in events: `joints_deg` [deg, m], or `tool` [m] with or without `rpy_deg`; `arm`; `hand`, `to`.

        Raises:
            UsageError: A key is wrong, the arm or person does not exist, or the target cannot be reached.
        """
        self._happen(**{**keys, "reach": robot})

    def release(self, name: str, arm: str = "arm", *, hand: str | None = None, joint: str | None = None) -> None:
        """Release an arm to its commands, a hand to its posture, or a joint to its own motion."""
        self._happen(release=name, arm=arm, hand=hand, joint=joint)

    def lead(self, mechanism: str, joint: str, to_deg: float | Sequence[float]) -> None:
        """Move a joint to a value [deg, m], or a ball to a rotation vector, and hold it; UsageError if impossible."""
        goal = {"rotation_deg": tuple(to_deg)} if isinstance(to_deg, Sequence) else {"to_deg": to_deg}
        self._happen(lead=mechanism, joint=joint, **goal)

    def set_goal(self, robot: str, place: Sequence[float], heading: float | None = None) -> None:
        """Give a robot's navigator a goal [m, rad] in the frame of its estimate; UsageError if impossible."""
        self._happen(goal=robot, to=tuple(place), heading_deg=None if heading is None else math.degrees(heading))

    def schedule(
        self, event: WorldEvent, *, instead_of: WorldEvent | None = None, before: WorldEvent | None = None
    ) -> WorldEvent:
        """Schedule an event, like those of the world file, for a future tick; see `WorldScript.schedule`."""
        return self._script.schedule(event, instead_of=instead_of, before=before)

    def happened(self) -> tuple[WorldEvent, ...]:
        """Return the events of the world since the last call, with their times."""
        return self._script.happened()

    @property
    def looks(self) -> Looks:
        """Light, and removed things."""
        return self._script.looks

    def things(self) -> dict[str, Pose]:
        """Return the poses of all movable things except robots, world frame: `obstacle/NAME`, and `door/NAME`.

        For a door, the position of its hinge and the heading of its leaf. Removed things are left out.
        """
        return self._script.things()

    def state(self) -> tuple[Array, Array]:
        """Return copies of MuJoCo's positions and velocities, shapes (nq,) and (nv,)."""
        return self.data.qpos.copy(), self.data.qvel.copy()

    def close(self) -> None:
        """Release the renderer, which the next picture opens again, and end programs of controllers."""
        self._canvases.close()
        self._mechanisms.close()

    def _set_up(self) -> None:
        """Create movers, doors and mechanisms, and put the robots at their starts, in a new state and model."""
        world = self.world
        own = weakref.proxy(self)  # Weak, so that parts of a simulation do not keep it, and its model, in memory.
        self._script = WorldScript(
            self.model,
            self.data,
            world,
            seed=self.seed,
            arm=lambda robot, name: own._robot(robot).arm(name),
            tune=lambda key, value: own._tuning.set(key, value),
            lead=lambda name, goals: own._mechanisms.lead(name, goals, own.tick),
            barred=lambda name, goals: own._mechanisms.barred(name, goals, own.tick),
        )
        self._radio = RadioNet([robot.name for robot in world.robots], world.radio, seed=self.seed)
        self._robots = {
            robot.name: SimulatedRobot(
                self.model,
                self.data,
                robot,
                world=world,
                seed=self.seed,
                canvas=partial(self._canvases.of, self.model, light=self._light),
                received=partial(self._radio.received, robot.name),
            )
            for robot in world.robots
        }
        self._tuning = Tuning(world, self._robots)
        self._mechanisms = Mechanisms(self.model, self.data, world, seed=self.seed)
        self._bumpers = Bumpers(self.model, self.data, [robot.bumper for robot in self._robots.values()], world)
        self._after_each = list(chain(*(robot.after_step for robot in self._robots.values())))
        self._actuations = None
        self.robots: Mapping[str, RobotInfo] = MappingProxyType({n: robot.info for n, robot in self._robots.items()})
        """Data sheet of each robot, by name."""
        self._script.let_happen(0.0)
        self._refresh()

    def _robot(self, name: str) -> SimulatedRobot:
        if name not in self._robots:
            meant = did_you_mean(name, self._robots)
            raise UsageError(Sentence("no robot '{name}' in this world{meant}", name, meant))
        return self._robots[name]

    def _happen(self, **keys: object) -> None:
        """Execute an event now, and update the state."""
        self._script.happen(event_from({"time": self.time, **keys}), self.time)
        self._refresh()

    def _refresh(self) -> None:
        """Update positions and contacts from the state."""
        bring_up(self.model, self.data)
        mujoco.mj_collision(self.model, self.data)

    def _run_physics(self) -> list[str]:
        """Take the physics steps of one tick; return the warnings, which MuJoCo would otherwise print and log."""
        if self._actuations is None:
            own = chain(*(robot.acting() for robot in self._robots.values()))
            self._actuations = [*self._mechanisms.acting(), *self._mechanisms.controls(), *own]
        with collected_warnings() as messages:
            acting = [*self._mechanisms.held(), *self._actuations]
            after_each = [*self._bumpers.before_tick(forced=self._script.acts), *self._after_each]
            self._script.run(self.tick, actuations=acting, after_each=after_each)
        return messages
