"""Additional pictures, rendered beside the run in a separate thread when time allows."""

import asyncio
import math
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

from mjsim.record import Tick
from mjsim.sim import Onlooker, Orbit
from mjsim.web.run.requests import Outside
from mjsim.web.run.shots import depth_shown, jpeg, segmentation_shown
from mjsim.world import World

SIZE = (960, 600)
"""Size of external views [px]."""
MAX_REST = 1.0
"""Maximum pause after a picture, however long it took: the first one waits until the world is compiled [s]."""


class Painter:
    """Renders the state of a tick from any view. Its thread owns an OpenGL context."""

    def __init__(self, world: World, share: Callable[[], float]) -> None:
        """Initialise.

        Args:
            world: The world to render.
            share: Returns the fraction of time available for rendering, above 0, at most 1.
        """
        self._onlooker, self._share = Onlooker(world), share
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="mjsim-painter")
        self._turn = asyncio.Lock()
        self._free_at = 0.0

    async def outside(self, request: Callable[[], tuple[Tick, Outside]]) -> tuple[float, bytes]:
        """Return time [s] and JPEG of an external view; `request` returns what to render when its turn comes."""

        def draw() -> tuple[float, bytes]:
            tick, view = request()
            orbit = Orbit(math.radians(view.azimuth_deg), math.radians(view.elevation_deg), view.distance, view.at)
            self._onlooker.show(tick.qpos, tick.looks)
            return tick.time, jpeg(self._onlooker.outside(orbit, width=SIZE[0], height=SIZE[1]))

        return await self._drawn(draw)

    async def onboard(self, request: Callable[[], Tick], camera: str, *, kind: str) -> tuple[float, bytes]:
        """Return time [s] and JPEG of a camera's 'depth' or 'segmentation', as `kind` says; 'ROBOT/CAMERA' names it."""

        def draw() -> tuple[float, bytes]:
            tick = request()
            self._onlooker.show(tick.qpos, tick.looks)
            robot, _, name = camera.partition("/")
            kinds = {"depth": kind == "depth", "segmentation": kind == "segmentation"}
            frame = self._onlooker.onboard(robot, name, stamp=tick.time, **kinds)
            if kind == "segmentation":
                return tick.time, jpeg(segmentation_shown(frame))
            assert frame.depth is not None, "an onlooker's cameras have depth"
            return tick.time, jpeg(depth_shown(frame.depth))

        return await self._drawn(draw)

    def close(self) -> None:
        """Release everything after the current picture."""
        self._thread.submit(self._onlooker.close)
        self._thread.shutdown()

    async def _drawn(self, draw: Callable[[], tuple[float, bytes]]) -> tuple[float, bytes]:
        async with self._turn:
            await asyncio.sleep(self._free_at - time.perf_counter())
            began = time.perf_counter()
            drawn = await asyncio.get_running_loop().run_in_executor(self._thread, draw)
            ended = time.perf_counter()
            self._free_at = ended + min((ended - began) * (1.0 / self._share() - 1.0), MAX_REST)
            return drawn
