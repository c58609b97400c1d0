"""Pictures of recorded states: the same scene drawn again, from any camera of it."""

from types import TracebackType
from typing import Self

import mujoco

from mjsim.compile import compile_world
from mjsim.geometry import Array
from mjsim.interface import Picture
from mjsim.sim.canvas import Quality
from mjsim.sim.renderer import Renderer
from mjsim.world import World


class Playback:
    """A world whose state is given, not simulated. Use from one thread, and close when done."""

    def __init__(self, world: World, *, width: int, height: int, quality: Quality = "normal") -> None:
        """Compile the world; pictures are width x height [px]."""
        self._model = compile_world(world).compile()
        self._data = mujoco.MjData(self._model)
        self._renderer = Renderer(self._model, width=width, height=height, quality=quality)

    def picture(self, qpos: Array, camera: str, out: Picture | None = None) -> Picture:
        """Return what a camera sees in a state, RGB, shape (height, width, 3).

        Args:
            qpos: MuJoCo's positions, shape (nq,), as a recording holds them.
            camera: 'ROBOT/CAMERA', 'ROBOT/chase' or 'overview'.
            out: Written and returned when given.

        Raises:
            UsageError: There is no such camera.
        """
        self._data.qpos[:] = qpos
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_camlight(self._model, self._data)
        return self._renderer.render(self._data, camera, out)

    def close(self) -> None:
        """Give back what was made for drawing; a second call does nothing."""
        self._renderer.close()

    def __enter__(self) -> Self:
        """Return itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close."""
        self.close()
