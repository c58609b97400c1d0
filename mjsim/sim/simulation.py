"""The simulation: a world in MuJoCo, its robots, and time."""

from collections.abc import Mapping
from types import MappingProxyType, TracebackType
from typing import Self

import mujoco
import numpy as np

from mjsim.compile import compile_world
from mjsim.compile.pictures import read_picture
from mjsim.errors import PhysicsFault, UsageError, did_you_mean
from mjsim.geometry import Array, Pose
from mjsim.interface import BeaconInfo, Command, MarkerInfo, Observation, Picture, RobotInfo, WheelCommand, WorldMap
from mjsim.sim.canvas import Canvas, Quality
from mjsim.sim.robot import SimulatedRobot
from mjsim.world.hung import hung
from mjsim.world.model import World
from mjsim.world.plan import segments

FASTEST = 100.0
"""No robot of ours is as fast unless the physics failed [m/s]."""


class Simulation:
    """A world at work: sense, decide, apply, step.

    One tick is: `sense` every robot, let the modules decide, `apply` every command, `step`. Use from one thread at
    a time, and close it (or use `with`) when cameras have been used.
    """

    def __init__(self, world: World, *, seed: int | None = None) -> None:
        """Compile the world and put the robots at their starts.

        Args:
            world: What is simulated.
            seed: Of all chance in the run; that of the world unless given.

        Raises:
            UsageError: The seed is negative, a camera's rate does not divide the loop's, or the world is more than
                MuJoCo can hold.
        """
        self.world = world
        self.seed = world.run.seed if seed is None else seed
        if self.seed < 0:
            raise UsageError(f"seed is {self.seed}; it must be 0 or more")
        self.model: mujoco.MjModel = compile_world(world).compile()
        self.data = mujoco.MjData(self.model)
        self.dt: float = world.run.steps_per_tick * self.model.opt.timestep
        """Period of the loop [s]."""
        self.tick = 0
        """Ticks since the start."""
        self._canvases: dict[Quality, Canvas] = {}
        self._robots = {
            robot.name: SimulatedRobot(self.model, self.data, robot, world=world, seed=self.seed, canvas=self._canvas)
            for robot in world.robots
        }
        self._speeds = np.array(
            [self.model.joint(f"{name}/free").dofadr[0] + axis for name in self._robots for axis in range(3)], dtype=int
        )
        self.robots: Mapping[str, RobotInfo] = MappingProxyType({n: robot.info for n, robot in self._robots.items()})
        """What modules are told of each robot, by name."""
        self.catalogue: Mapping[str, BeaconInfo] = MappingProxyType(_catalogue(world))
        """What modules are told of each beacon, by name."""
        self.map: WorldMap | None = _map(world) if world.run.map == "known" else None
        """What modules are told of the room; None when the world says `map: unknown`."""
        self._look()

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.tick * self.dt

    def sense(self, robot: str) -> Observation:
        """Return all that a robot senses at this tick; computed once a tick, pictures only when due."""
        return self._robot(robot).sense(self.tick)

    def apply(self, robot: str, command: Command | WheelCommand) -> None:
        """Give a robot a command, which it follows within its limits until it gets another.

        Raises:
            UsageError: There is no such robot, or the command does not fit it or is not finite.
        """
        self._robot(robot).command(command)

    def step(self) -> None:
        """Go on by one tick.

        Raises:
            PhysicsFault: MuJoCo warned, or a state is out of all bounds; names the time.
        """
        for robot in self._robots.values():
            robot.before_step(self.tick)
        said = self._run_physics()
        self.tick += 1
        self._look()
        self._check(said)
        for robot in self._robots.values():
            robot.after_step()

    def truth(self, robot: str) -> Pose:
        """Return where a robot is, world frame."""
        return self._robot(robot).truth()

    def truths(self) -> dict[str, Pose]:
        """Return where each robot is, world frame."""
        return {name: robot.truth() for name, robot in self._robots.items()}

    def identities(self, robot: str) -> tuple[str | None, ...]:
        """Return which beacon each sighting of a robot's sensors at this tick is of, None for one of nothing.

        For recordings and statistics; modules are told what `sense` gives alone.
        """
        return self._robot(robot).identities(self.tick)

    def state(self) -> tuple[Array, Array]:
        """Return copies of MuJoCo's positions and velocities, shapes (nq,) and (nv,)."""
        return self.data.qpos.copy(), self.data.qvel.copy()

    def close(self) -> None:
        """Give back what the cameras draw with; a second call does nothing."""
        for canvas in self._canvases.values():
            canvas.close()

    def __enter__(self) -> Self:
        """Return the simulation itself; the end of the block closes it."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the simulation."""
        self.close()

    def _robot(self, name: str) -> SimulatedRobot:
        if name not in self._robots:
            raise UsageError(f"no robot '{name}' in this world{did_you_mean(name, self._robots)}")
        return self._robots[name]

    def _canvas(self, quality: Quality) -> Canvas:
        """Return what all cameras of a quality draw on; nothing of OpenGL is touched until the first picture."""
        if quality not in self._canvases:
            self._canvases[quality] = Canvas(self.model, quality=quality)
        return self._canvases[quality]

    def _look(self) -> None:
        """Bring places and contacts up to the state; mj_step leaves those from before its last step."""
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)
        mujoco.mj_camlight(self.model, self.data)
        mujoco.mj_collision(self.model, self.data)

    def _run_physics(self) -> list[str]:
        """Take the physics steps of one tick; return the warnings, which MuJoCo else prints and writes to a file."""
        said: list[str] = []
        before = mujoco.get_mju_user_warning()
        mujoco.set_mju_user_warning(said.append)
        try:
            feeling = [robot for robot in self._robots.values() if robot.feels]
            # One call for all steps is quicker than one each.
            calls, steps = (self.world.run.steps_per_tick, 1) if feeling else (1, self.world.run.steps_per_tick)
            for _ in range(calls):
                mujoco.mj_step(self.model, self.data, steps)
                for robot in feeling:
                    robot.feel_step()
        finally:
            mujoco.set_mju_user_warning(before)
        return said

    def _check(self, said: list[str]) -> None:
        """Raise when the state is no longer to be trusted."""
        warning, speeds = self.data.warning, self.data.qvel[self._speeds]
        if warning.number.any():
            kind = int(np.flatnonzero(warning.number)[0])
            what = said[0] if said else mujoco.mju_warningText(kind, int(warning.lastinfo[kind]))
            raise PhysicsFault(f"physics failed at {self.time:.2f} s: {what.partition(' Time = ')[0]}")
        if not np.isfinite(self.data.qpos).all() or not (np.abs(speeds) < FASTEST).all():
            raise PhysicsFault(f"physics failed at {self.time:.2f} s: a robot moves at {np.abs(speeds).max():g} m/s")


def _catalogue(world: World) -> dict[str, BeaconInfo]:
    pictures: dict[str, Picture] = {}
    known = world.run.map == "known"
    catalogue = {}
    for item in hung(world):
        beacon, marker, picture = item.beacon, item.beacon.marker, None
        if beacon.image is not None:
            if beacon.image not in pictures:
                pictures[beacon.image] = read_picture(world.read_asset(beacon.image))
            picture = pictures[beacon.image]
        rows, columns = (1, 1) if picture is None else picture.shape[:2]
        catalogue[beacon.name] = BeaconInfo(
            name=beacon.name,
            picture=picture,
            width=beacon.width,
            height=beacon.width * rows / columns,
            pose=item.place if known and item.fixed else None,
            center=item.center if known and item.fixed else None,
            marker=MarkerInfo(marker.dictionary, marker.id) if marker is not None else None,
        )
    return catalogue


def _map(world: World) -> WorldMap:
    beacons = {item.beacon.name: item.place for item in hung(world) if item.fixed}
    return WorldMap(segments=segments(world), beacons=beacons)
