"""Print how pictures, ticks and filters grow with the world, and draw it: docs/images/growth-*.png.

    python scripts/measure/growth.py [--runs 5] [-o docs/images]

Times are those of the processor, of all threads, so that other programs disturb them less; medians of the runs, which
take turns. Pictures are 640 x 480.
"""

import argparse
import statistics
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

from matplotlib.ticker import LogLocator

from mjsim.algorithms.ekf_slam import EkfSlamFilter, InvariantEkfSlamFilter
from mjsim.bench.figure import Clock, Once, Prepare
from mjsim.bench.filters import filter_time
from mjsim.bench.large import large_floor
from mjsim.bench.pictures import office_geom_by_geom, picture_floor
from mjsim.bench.scenes import OFFICE_ACROSS, OFFICE_UP, gallery, hall, office_places
from mjsim.geometry import Pose
from mjsim.report import png_of, sheet
from mjsim.run import Driver, ticks
from mjsim.sim import Renderer, Simulation, hiding
from mjsim.world import World, parse_world

WIDTH, HEIGHT = 640, 480
COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7")
"""Of curves; people with colour blindness tell them apart (Okabe and Ito, 2008)."""
SEGMENTS, BEACONS, ROBOTS, LANDMARKS = (100, 1000, 10_000), (10, 100, 1000), (1, 4, 16), (50, 200, 1000)
CAMERA = f"{{camera: front, at: [0.1, 0, 1], width: {WIDTH}, height: {HEIGHT}, rate_hz: 25}}"
SMALL = "{camera: front, at: [0.1, 0, 1], width: 320, height: 240, rate_hz: 25}"
LIDAR = "{lidar: scan, beams: 180, rate_hz: 25}"
ASKED, NEVER = hiding.LEAST_GEOMS, 10**9
"""From how many geoms on it is asked which of them walls hide."""
SPOTS = ((0.07, 1.0, 0), (0.07, 2.0, 0), (5.93, 2.0, 180), (5.93, 3.5, 180), (5.0, 4.93, -90))
"""Of beacons in a room of the office: x, y [m], heading [deg]."""


@dataclass(frozen=True)
class GrowthCurve:
    """One curve: what it shows, and what measures it at each size."""

    name: str
    prepare: Callable[[int], Prepare]
    most: int = 10**9
    """Beyond this size it takes too long."""


@dataclass(frozen=True)
class GrowthPlot:
    """One plot and table."""

    name: str
    title: str
    across: str
    up: str
    sizes: Sequence[int]
    curves: Sequence[GrowthCurve]


def pictures_of(make: Callable[[], World], places: Callable[[], Sequence[Pose]], *, worth: int) -> Prepare:
    """Measure pictures per second of a world from places; `worth`: number of geoms from which occlusion is tested."""

    @contextmanager
    def prepare() -> Iterator[Once]:
        with Simulation(make()) as sim, Renderer(sim.model, width=WIDTH, height=HEIGHT) as renderer:
            looked = places()

            def once(clock: Clock) -> float:
                seconds, hiding.LEAST_GEOMS = 0.0, worth
                for place in looked:
                    sim.move("scout", place)
                    began = clock()
                    renderer.render(sim.data, "scout/front")
                    seconds += clock() - began
                hiding.LEAST_GEOMS = usual
                return len(looked) / seconds

            usual = hiding.LEAST_GEOMS
            once(time.process_time)
            yield once

    return prepare


def in_office(worth: int) -> Callable[[int], Prepare]:
    """Return what measures a picture in an office of so many wall segments."""
    return lambda segments: pictures_of(lambda: office(segments), lambda: office_places(segments), worth=worth)


def in_furnished_office(beacons: int) -> Prepare:
    """Measure a picture in an office with so many beacons."""
    return pictures_of(lambda: office(1000, beacons), lambda: office_places(1000), worth=ASKED)


def office(segments: int, beacons: int = 0) -> World:
    """Return the large floor with a camera and beacons on the walls of its rooms, five a room."""
    files = sorted({beacon.image for beacon in gallery().beacons})
    across = max(1, round((segments // 5) ** 0.5))
    hung = []
    for k in range(beacons):
        room, (x, y, heading) = k // len(SPOTS), SPOTS[k % len(SPOTS)]
        at = [OFFICE_ACROSS * (room % across) + x, OFFICE_UP * (room // across) + y]
        hung.append(
            f"  - {{name: b{k}, image: {files[k % len(files)]}, at: {at}, heading_deg: {heading}, width: 0.6}}\n"
        )
    robot = f"robots: [{{name: scout, preset: pioneer3dx, at: [1.5, 1.5], sensors: [{CAMERA}]}}]\n"
    return parse_world(
        large_floor(segments).partition("robots:")[0] + ("beacons:\n" if hung else "") + "".join(hung) + robot
    )


def one_hall(beacons: int) -> World:
    """Return one hall of 40 m x 40 m whose beacons stand in rows, all of them in view."""
    files = sorted({beacon.image for beacon in gallery().beacons})
    rows = [
        f"  - {{name: b{k}, image: {files[k % len(files)]}, at: [{4 + 1.1 * (k // 32)}, {2 + 1.15 * (k % 32)}],"
        f" heading_deg: 180, width: 0.6, center: {0.5 + 0.05 * (k // 32)}}}\n"
        for k in range(beacons)
    ]
    return parse_world(
        "mjsim: 1\nname: hall\nwalls: [{points: [[0, 0], [40, 0], [40, 40], [0, 40]], closed: true}]\nbeacons:\n"
        + "".join(rows)
        + f"robots: [{{name: scout, preset: pioneer3dx, at: [1, 20], sensors: [{CAMERA}]}}]\n"
    )


def hall_places() -> list[Pose]:
    """Return places at one side of the hall, looking across."""
    return [Pose(1.0, 4.0 + 4.0 * k, 0.1 * (k - 4)) for k in range(8)]


def ticks_of(sensor: str) -> Callable[[int], Prepare]:
    """Return what measures a tick [ms] of so many robots, each with a sensor that is due at every tick."""

    def of(robots: int) -> Prepare:
        @contextmanager
        def prepare() -> Iterator[Once]:
            world = hall(sensor, robots=robots)
            with Simulation(world) as sim:
                loop = ticks(sim, {robot.name: Driver() for robot in world.robots})
                next(loop)

                def once(clock: Clock) -> float:
                    began = clock()
                    for _ in range(25):
                        next(loop)
                    return 1e3 * (clock() - began) / 25

                once(time.process_time)
                yield once

        return prepare

    return of


PLOTS = (
    GrowthPlot(
        "walls",
        "Pictures in an office",
        "wall segments",
        "pictures per second",
        SEGMENTS,
        (
            GrowthCurve("normal rendering", in_office(ASKED)),
            GrowthCurve("without skipping what walls occlude", in_office(NEVER)),
            GrowthCurve("wall by wall, without culling", lambda n: office_geom_by_geom(n), 1000),
            GrowthCurve("floor: one textured quad", lambda n: picture_floor(WIDTH, HEIGHT)),
        ),
    ),
    GrowthPlot(
        "beacons",
        "Pictures among beacons",
        "beacons",
        "pictures per second",
        BEACONS,
        (
            GrowthCurve("in an office, five per room", in_furnished_office),
            GrowthCurve(
                "in one hall, in front of the camera",
                lambda n: pictures_of(lambda: one_hall(n), hall_places, worth=ASKED),
            ),
            GrowthCurve("floor: one textured quad", lambda n: picture_floor(WIDTH, HEIGHT)),
        ),
    ),
    GrowthPlot(
        "robots",
        "A tick with several robots",
        "robots",
        "ms per tick",
        ROBOTS,
        (
            GrowthCurve("with a lidar each", ticks_of(LIDAR)),
            GrowthCurve("with a camera each, 320 x 240", ticks_of(SMALL)),
            GrowthCurve("without", ticks_of("")),
        ),
    ),
    GrowthPlot(
        "landmarks",
        "A prediction and an update with 10 sightings",
        "landmarks in the map",
        "ms",
        LANDMARKS,
        (
            GrowthCurve(
                "first estimates", lambda n: filter_time(lambda: EkfSlamFilter(jacobians="first-estimates"), n)
            ),
            GrowthCurve("invariant", lambda n: filter_time(InvariantEkfSlamFilter, n)),
        ),
    ),
)


def measured(plot: GrowthPlot, *, runs: int) -> Mapping[tuple[str, int], float]:
    """Return the median at each size of each curve; the runs take turns."""
    values: dict[tuple[str, int], list[float]] = {}
    for size in plot.sizes:
        with ExitStack() as stack:
            ready = [
                (curve.name, stack.enter_context(curve.prepare(size)())) for curve in plot.curves if size <= curve.most
            ]
            for _ in range(runs):
                for name, once in ready:
                    values.setdefault((name, size), []).append(once(time.process_time))
    return {key: statistics.median(got) for key, got in values.items()}


def table(plot: GrowthPlot, found: Mapping[tuple[str, int], float]) -> Iterator[str]:
    """Yield the rows of a table, a line a curve."""
    yield f"| {plot.up} | " + " | ".join(f"{size:,} {plot.across}" for size in plot.sizes) + " |"
    yield "|---" * (1 + len(plot.sizes)) + "|"
    for curve in plot.curves:
        cells = [f"{found[curve.name, size]:.3g}" if (curve.name, size) in found else "" for size in plot.sizes]
        yield f"| {curve.name} | " + " | ".join(cells) + " |"


def drawn(plot: GrowthPlot, found: Mapping[tuple[str, int], float]) -> bytes:
    """Return the plot as a PNG."""
    figure, (axes,) = sheet(1, height=3.8)
    for curve, color in zip(plot.curves, COLORS, strict=False):
        sizes = [size for size in plot.sizes if (curve.name, size) in found]
        dashes = "--" if curve.name.startswith("floor") else "-"
        values = [found[curve.name, size] for size in sizes]
        axes.plot(sizes, values, dashes, marker="o", markersize=4, color=color, label=curve.name)
    axes.set(title=plot.title, xlabel=plot.across, ylabel=plot.up, xscale="log", yscale="log")
    axes.set_xticks(plot.sizes, [f"{size:,}" for size in plot.sizes])
    axes.minorticks_off()
    axes.margins(0.08, 0.15)
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axes.legend(frameon=False, fontsize=8, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    return png_of(figure)


def main() -> None:
    """Measure, print and draw."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--only", nargs="*", default=[plot.name for plot in PLOTS])
    parser.add_argument("-o", "--output", type=Path, default=Path("docs/images"))
    options = parser.parse_args()
    for plot in PLOTS:
        if plot.name in options.only:
            found = measured(plot, runs=options.runs)
            print(f"\n{plot.title}\n\n" + "\n".join(table(plot, found)), flush=True)
            (options.output / f"growth-{plot.name}.png").write_bytes(drawn(plot, found))


if __name__ == "__main__":
    main()
