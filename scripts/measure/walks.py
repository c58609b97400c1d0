"""List the files of mjsim that three operations run through, in order.

python scripts/measure/walks.py [--files]

A wall from its text to MuJoCo; an estimate from the tick that holds it to statistics; an edit from the page's message
to the text. Calls that come to another file than the call before are counted too. Each is done once before it is
watched, so that only files count whose functions run.
"""

import argparse
import itertools
import sys
import tempfile
import threading
from collections.abc import Callable
from pathlib import Path
from types import FrameType

import mjsim
from mjsim.compile import compile_world
from mjsim.record import Recorder, read_recording
from mjsim.run import drivers_of, ticks
from mjsim.world import Change, edited

ROOT = Path(mjsim.__file__).parent
WALL = "mjsim: 1\nwalls: [{points: [[0, 0], [4, 0]]}]\n"
ROOM = """
mjsim: 1
robots: [{name: scout, at: [0, 0], odometry: {noise: {distance: 0.01}}}]
run:
  seconds: 0.4
  drivers: {scout: {estimator: {use: "mjsim.algorithms.ekf_slam:EkfSlam"}}}
"""


def wall() -> Callable[[], object]:
    """Return a function that reads a wall and compiles it."""
    return lambda: compile_world(mjsim.parse_world(WALL)).compile()


def estimate() -> Callable[[], object]:
    """Return a function that records ticks with estimates, reads them, and computes their statistics."""
    world = mjsim.parse_world(ROOM)
    with mjsim.Simulation(world) as sim:
        told = list(itertools.islice(ticks(sim, drivers_of(world)), 10))

    def walk() -> None:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "run.mcap"
            with Recorder(path, world=world, seed=1, robots=sim.robots, metadata={"seconds": "0.4"}) as recorder:
                for tick in told:
                    recorder.write(tick)
            mjsim.statistics(read_recording(path))

    return walk


def edit() -> Callable[[], object]:
    """Return a function that moves an end of a wall as the page does."""
    return lambda: edited(WALL, [Change("set", ("walls", 0, "points", 1, 0), 5.0)])


def calls(work: Callable[[], object]) -> list[str]:
    """Return the file of mjsim of each of its functions that is called, in each thread in the order of the calls."""
    work()
    found: dict[int, list[str]] = {}

    def called(frame: FrameType, event: str, _: object) -> None:
        path = frame.f_code.co_filename
        if event == "call" and path.startswith(str(ROOT)):
            found.setdefault(threading.get_ident(), []).append(str(Path(path).relative_to(ROOT)))

    threading.setprofile(called)
    sys.setprofile(called)
    try:
        work()
    finally:
        sys.setprofile(None)
        threading.setprofile(None)
    return [*itertools.chain(*found.values())]


def main() -> None:
    """Print the length of each walk, and the files when asked."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--files", action="store_true", help="name them too")
    options = parser.parse_args()
    for thing in (wall, estimate, edit):
        entered = calls(thing())
        files = [*dict.fromkeys(entered)]
        changes = sum(one != other for one, other in itertools.pairwise(entered))
        print(f"{thing.__name__}: {len(files)} files, {changes} changes from one to another")
        if options.files:
            print(*(f"  {file}" for file in files), sep="\n")


if __name__ == "__main__":
    main()
