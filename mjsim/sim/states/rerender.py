"""Renders the camera pictures of a recorded run again, from the same states with the same noise."""

from collections.abc import Callable, Sequence
from typing import Any

import mujoco
import numpy as np

from mjsim.closing import Closes
from mjsim.errors import RecordingError
from mjsim.geometry import Array
from mjsim.interface import CameraFrame
from mjsim.sentences import Sentence
from mjsim.sim.rendering import Canvases
from mjsim.sim.sensors import OnboardCamera, ticks_between
from mjsim.sim.states.static_scene import StillScene
from mjsim.sim.streams import streams_of
from mjsim.world import Camera, Looks, World

SAME_TIME = 1e-6
"""Tolerance between a stamp and the time of its tick [s]."""


class Retake(Closes):
    """The onboard cameras of one robot in a recorded run; pictures may be asked for in any order, and again.

    Use from one thread, and close when done. The world is compiled at the first picture.
    """

    def __init__(
        self,
        world: World,
        robot: str,
        *,
        seed: int,
        times: Array,
        qpos: Array,
        qvel: Array,
        looks: Callable[[int], Looks],
    ) -> None:
        """Store the recorded states.

        Args:
            world: World of the run.
            robot: Robot with the cameras.
            seed: Seed of the run.
            times: Times of its ticks, shape (N,) [s].
            qpos: MuJoCo's positions, shape (N, nq).
            qvel: MuJoCo's velocities, shape (N, nv), for motion blur.
            looks: Returns the looks of the world at a row.
        """
        self._world, self._seed, self._looks = world, seed, looks
        self._robot = next(each for each in world.robots if each.name == robot)
        self._times, self._qpos, self._qvel = times, qpos, qvel
        self._period = 1.0 / world.run.rate_hz
        self._canvases = Canvases()
        self._cameras: dict[str, _Again] = {}

    def frame(self, camera: str, stamp: float) -> CameraFrame:
        """Return the frame of a camera, identical to the last bit on the same OpenGL backend.

        Args:
            camera: Name of the camera.
            stamp: Time of the picture [s].

        Raises:
            RecordingError: The time is before the start of the recording.
        """
        if self._row(stamp) is None:
            raise RecordingError(
                Sentence(
                    "camera '{camera}' took its picture at {stamp:g} s; no tick at that time is recorded", camera, stamp
                )
            )
        if not self._cameras:
            self._compile()
        return self._cameras[camera].frame(stamp, tick=round(stamp / self._period))

    def close(self) -> None:
        """Release the renderer; a second call does nothing."""
        self._canvases.close()

    def _row(self, stamp: float) -> int | None:
        row = int(np.searchsorted(self._times, stamp - SAME_TIME))
        return row if row < len(self._times) and self._times[row] - stamp <= SAME_TIME else None

    def _at(self, tick: int) -> mujoco.MjData | None:
        """Return the state at a tick, None if it is not recorded."""
        row = self._row(tick * self._period)
        if row is None:
            return None
        self._scene.show(self._qpos[row], qvel=self._qvel[row], looks=self._looks(row))
        return self._scene.data

    def _compile(self) -> None:
        world = self._world
        self._scene = StillScene(world)
        model = self._scene.model
        for sensor in self._robot.sensors:
            if isinstance(sensor, Camera):
                canvas = self._canvases.of(model, sensor.quality, self._scene.light)
                streams = streams_of(self._seed, self._robot.name, sensor.camera)
                camera = OnboardCamera(model, self._robot, sensor, streams=streams, canvas=canvas)
                ticks = ticks_between(world.run.rate_hz, sensor.rate_hz)
                self._cameras[sensor.camera] = _Again(camera, self._at, ticks=ticks, period=self._period)


class _Again:
    """A camera that can be set to its state before any picture: random streams, and the memory of its exposure."""

    def __init__(
        self, camera: OnboardCamera, state: Callable[[int], mujoco.MjData | None], *, ticks: int, period: float
    ) -> None:
        """Start before the first picture.

        Args:
            camera: The camera.
            state: Returns the recorded state at a tick.
            ticks: Ticks between two pictures.
            period: Period of a tick [s].
        """
        self._camera, self._state_at, self._ticks, self._period = camera, state, ticks, period
        self._states: list[tuple[Sequence[Any], Any]] = [self._state()]
        """Random streams and memory before each picture."""

    def frame(self, stamp: float, *, tick: int) -> CameraFrame:
        """Return the frame of the camera with the random numbers of the picture due at a tick.

        Raises:
            RecordingError: There is no state at that tick.
        """
        number = tick // self._ticks
        if number >= len(self._states):
            self._bring_to(len(self._states) - 1)
            while number >= len(self._states):
                self._pass(len(self._states) - 1)
                self._states.append(self._state())
        data = self._state_at(tick)
        if data is None:
            raise RecordingError(Sentence("there is no tick at {stamp:g} s", stamp))
        self._bring_to(number)
        return self._camera.frame(data, stamp)

    def _pass(self, number: int) -> None:
        """Skip a picture; it is taken if later pictures depend on it."""
        data = self._state_at(number * self._ticks) if self._camera.imager.remembers else None
        if data is None:
            self._camera.pass_over()
        else:
            self._camera.frame(data, number * self._ticks * self._period)

    def _state(self) -> tuple[list[Any], Any]:
        return [chance.bit_generator.state for chance in self._camera.chances], self._camera.imager.memory

    def _bring_to(self, number: int) -> None:
        chances, self._camera.imager.memory = self._states[number]
        for chance, state in zip(self._camera.chances, chances, strict=True):
            chance.bit_generator.state = state
