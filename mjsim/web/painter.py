"""Pictures that nobody's modules asked for, drawn beside the run in a thread of their own, when time allows."""

import asyncio
import math
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

from mjsim.record.tick import Tick
from mjsim.sim.onlooker import Onlooker, Orbit
from mjsim.web.orders import Outside
from mjsim.web.shots import depth_shown, jpeg, segmentation_shown
from mjsim.world import World

SIZE = (960, 600)
"""Of views from outside [px]."""


class Painter:
    """Draws the state of a tick from any view. Its thread owns an OpenGL context of its own."""

    def __init__(self, world: World, share: Callable[[], float]) -> None:
        """Get ready.

        Args:
            world: What is drawn.
            share: Tells how much of the time may be spent on drawing, above 0, at most 1.
        """
        self._onlooker, self._share = Onlooker(world), share
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="mjsim-painter")
        self._turn = asyncio.Lock()
        self._free_at = 0.0

    async def outside(self, tick: Tick, view: Outside) -> bytes:
        """Return a view from outside as JPEG."""
        orbit = Orbit(math.radians(view.azimuth_deg), math.radians(view.elevation_deg), view.distance, view.at)

        def draw() -> bytes:
            self._onlooker.show(tick.qpos, tick.looks)
            return jpeg(self._onlooker.outside(orbit, width=SIZE[0], height=SIZE[1]))

        return await self._drawn(draw)

    async def onboard(self, tick: Tick, camera: str, kind: str) -> bytes:
        """Return what a camera does not give to modules, 'depth' or 'segmentation', as JPEG; it is 'ROBOT/CAMERA'."""

        def draw() -> bytes:
            self._onlooker.show(tick.qpos, tick.looks)
            robot, _, name = camera.partition("/")
            frame = self._onlooker.onboard(robot, name, stamp=tick.time)
            if kind == "segmentation":
                return jpeg(segmentation_shown(frame))
            assert frame.depth is not None, "an onlooker's cameras have depth"
            return jpeg(depth_shown(frame.depth))

        return await self._drawn(draw)

    def close(self) -> None:
        """Give everything back; waits for the picture at hand."""
        self._thread.submit(self._onlooker.close)
        self._thread.shutdown()

    async def _drawn(self, draw: Callable[[], bytes]) -> bytes:
        async with self._turn:
            await asyncio.sleep(self._free_at - time.perf_counter())
            began = time.perf_counter()
            picture = await asyncio.get_running_loop().run_in_executor(self._thread, draw)
            ended = time.perf_counter()
            self._free_at = ended + (ended - began) * (1.0 / self._share() - 1.0)
            return picture
