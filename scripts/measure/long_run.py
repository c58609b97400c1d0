"""Run a world for long and print memory and speed by quarter, then what reading and measuring the recording takes.

    OMP_NUM_THREADS=1 LP_NUM_THREADS=1 python scripts/measure/long_run.py [--world FILE] [--seconds 3600] [-o RUN.mcap]

The project asks that one simulated hour of the gallery with its camera stays below 1.5 GB of memory, statistics
included, that its last quarter is as fast as its first, and that its recording is readable. A recording of an hour with
a camera has some 2 GB.
"""

import argparse
import tempfile
import time
from pathlib import Path

import mjsim
from mjsim.run import drivers_of

GALLERY = Path(__file__).resolve().parents[2] / "worlds" / "gallery.yaml"
LAPS = 1000
"""Of the tour, so that the robot drives all the time."""


def memory(key: str = "VmRSS") -> float:
    """Return how much memory this process has now, or had at most (VmHWM) [MB]."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith(f"{key}:"):
            return int(line.split()[1]) / 1e3
    return 0.0


class Quarters:
    """Prints a row whenever another quarter of a run is over."""

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds
        self._ends = seconds / 4
        self._wall, self._cpu = time.perf_counter(), time.process_time()
        print(f"{'until s':>10}{'x real time':>13}{'CPU ms a tick':>15}{'memory MB':>11}{'at most MB':>12}")

    def watch(self, tick: mjsim.Tick, dt: float) -> None:
        """Take a tick."""
        if tick.time + 1.5 * dt < self._ends:
            return
        wall, cpu = time.perf_counter(), time.process_time()
        quarter = self._seconds / 4
        print(
            f"{self._ends:>10.0f}{quarter / (wall - self._wall):>13.2f}"
            f"{1e3 * (cpu - self._cpu) / (quarter / dt):>15.2f}{memory():>11.0f}{memory('VmHWM'):>12.0f}",
            flush=True,
        )
        self._wall, self._cpu = wall, cpu
        self._ends += quarter


def main() -> None:
    """Run, read, measure."""
    parser = argparse.ArgumentParser(description="Memory and speed of a long run.")
    parser.add_argument("--world", type=Path, default=GALLERY)
    parser.add_argument("--seconds", type=float, default=3600.0, help="simulated")
    parser.add_argument("-o", type=Path, dest="record", help="the recording; gone at the end unless given")
    options = parser.parse_args()
    world = mjsim.load_world(options.world)
    world = with_laps(world)
    with tempfile.TemporaryDirectory() as folder, mjsim.Simulation(world) as sim:
        record = options.record or Path(folder) / "run.mcap"
        print(f"{memory():.0f} MB before the first tick")
        quarters = Quarters(options.seconds)
        recording = mjsim.run(
            sim,
            drivers=drivers_of(world),
            seconds=options.seconds,
            record=record,
            watch=lambda tick: quarters.watch(tick, sim.dt),
        )
        size = record.stat().st_size / 1e6
        print(f"run and read: {memory():.0f} MB, {memory('VmHWM'):.0f} MB at most; a file of {size:.0f} MB")
        began = time.process_time()
        figures = mjsim.statistics(recording)
        print(f"statistics: {time.process_time() - began:.1f} s, {memory():.0f} MB, {memory('VmHWM'):.0f} MB at most")
        print(f"{len(recording.time)} ticks read, whole: {recording.whole}")
        for name in recording.robots:
            if figures[name]["position_error_m"] is not None:
                print(f"{name}: position error, mean {figures[name]['position_error_m']['mean']:.3f} m")


def with_laps(world: mjsim.World) -> mjsim.World:
    """Return the world with tours that do not end."""
    from mjsim.world import with_settings

    settings = [
        f"run.drivers.{name}.navigator.laps={LAPS}"
        for name, modules in world.run.drivers.items()
        if modules.navigator is not None and "laps" in modules.navigator.arguments()
    ]
    return with_settings(world, settings)


if __name__ == "__main__":
    main()
