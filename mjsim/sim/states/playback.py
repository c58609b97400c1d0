"""Renders recorded states again, from any camera of the scene."""

import math
from bisect import bisect_right
from collections.abc import Iterable

import mujoco
import numpy as np

from mjsim.closing import Closes
from mjsim.compile import overview_of
from mjsim.geometry import Array
from mjsim.interface import Picture
from mjsim.sim.rendering import SEEN, Quality, Renderer
from mjsim.sim.states.static_scene import StillScene
from mjsim.world import World, WorldEvent, looks_after

SIGHT_HEIGHT = 0.5
"""Height above the floor of the line of sight that must be free [m]."""
CAMERA_DISTANCE = 0.1
"""Distance of a camera in front of an object that would hide its robot [m]."""
SOLID = np.array([1, 0, 0, 1, 0, 0], dtype=np.uint8)
"""Geom groups of solids: objects, and the invisible collision shapes of walls."""


class Playback(Closes):
    """Renders a world in given states. Use from one thread, and close when done."""

    def __init__(
        self,
        world: World,
        *,
        width: int,
        height: int,
        quality: Quality = "normal",
        groups: tuple[int, ...] = SEEN,
        events: Iterable[WorldEvent] = (),
    ) -> None:
        """Compile the world.

        Args:
            world: The world.
            width: Width of the pictures [px].
            height: Height of the pictures [px].
            quality: Quality, as for cameras.
            groups: Visible geom groups.
            events: Events of the run, in order of time.
        """
        self._world, self._events = world, tuple(events)
        self._times = [event.time for event in self._events]
        self._scene = StillScene(world)
        self._renderer = Renderer(
            self._scene.model, width=width, height=height, quality=quality, light=self._scene.light, groups=groups
        )

    def picture(self, qpos: Array, camera: str, out: Picture | None = None, *, time: float | None = None) -> Picture:
        """Return the image of a camera in a state, RGB, shape (height, width, 3).

        Args:
            qpos: MuJoCo's positions, shape (nq,), as in a recording.
            camera: 'ROBOT/CAMERA', 'ROBOT/chase' or 'overview'.
            out: Written and returned when given.
            time: Time of the state [s], for light and removed objects by events; by default before all events.

        Raises:
            UsageError: The camera does not exist.
        """
        past = 0 if time is None else bisect_right(self._times, time)
        self._scene.show(
            qpos, looks=looks_after(self._world, self._events[:past], time=math.inf if time is None else time)
        )
        if camera.endswith("/chase"):
            avoid_walls(self._scene.model, self._scene.data, camera)
        return self._renderer.render(self._scene.data, camera, out)

    def widen(self, reach: Array) -> None:
        """Widen the overview to motion beyond the initial world.

        Args:
            reach: Corners of a box around the motion, world frame, shape (2, 3) [m].
        """
        self._scene.model.camera("overview").pos = overview_of(self._world, reach)

    def close(self) -> None:
        """Release the renderer; a second call does nothing."""
        self._renderer.close()


def avoid_walls(model: mujoco.MjModel, data: mujoco.MjData, camera: str) -> None:
    """Move a camera fixed to a robot in front of objects that hide the robot, until poses are computed again."""
    index = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_CAMERA, camera)
    if index < 0:
        return
    body = model.cam_bodyid[index]
    start = data.xpos[body] + (0.0, 0.0, SIGHT_HEIGHT)
    offset = data.cam_xpos[index] - start
    length = float(np.linalg.norm(offset))
    free = mujoco.mj_ray(model, data, start, offset / length, SOLID, 1, body, np.empty(1, np.int32))
    if 0.0 <= free < length:
        data.cam_xpos[index] = start + offset * max(free - CAMERA_DISTANCE, 0.0) / length
