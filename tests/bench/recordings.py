"""Recording and video."""

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from mjsim.bench.figure import Clock, Once, Prepare
from mjsim.bench.loops import gallery_ticks
from mjsim.bench.scenes import gallery
from mjsim.record import Recorder, read_recording
from mjsim.run import run
from mjsim.sim import Simulation


def recording(*, pictures: bool) -> Prepare:
    """Measure the recording of ticks of the gallery: ticks a second."""

    @contextmanager
    def prepare() -> Iterator[Once]:
        world = gallery()
        with Simulation(world) as sim:
            robots = dict(sim.robots)
        told = gallery_ticks()

        def once(clock: Clock) -> float:
            with tempfile.TemporaryDirectory() as folder:
                path = Path(folder) / "run.mcap"
                recorder = Recorder(path, world=world, seed=1, robots=robots, metadata={}, pictures=pictures)
                began = clock()
                for tick in told:
                    recorder.write(tick)
                recorder.close()
                return len(told) / (clock() - began)

        yield once

    return prepare


@contextmanager
def film() -> Iterator[Once]:
    """Measure the video of a short gallery run: drawing and encoding."""
    from mjsim.video import make_video

    world = gallery()
    with tempfile.TemporaryDirectory() as folder:
        with Simulation(world) as sim:
            run(sim, seconds=3.0, record=Path(folder) / "run.mcap")
        recorded = read_recording(Path(folder) / "run.mcap")

        def once(clock: Clock) -> float:
            began = clock()
            make_video(recorded, Path(folder) / "run.mp4", overwrite=True)
            return len(recorded.time) / (clock() - began)

        yield once
