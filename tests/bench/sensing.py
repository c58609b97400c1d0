"""Sensor by sensor: what a look costs."""

from collections.abc import Iterator
from contextlib import contextmanager
from time import perf_counter

from mjsim.bench.figure import Clock, Figure, Once, Prepare
from mjsim.bench.scenes import gallery
from mjsim.sim import Simulation
from mjsim.world import format_world, parse_world

LOOKS = 20
CAMERA = "camera: eye, at: [0.1, 0, 1], rate_hz: 25"
CLEAN = f"{CAMERA}, noise: 0"
SENSORS = {
    "ring": "",
    "lidar-180": "{lidar: scan, beams: 180, rate_hz: 25, noise: {range: 0.01}}",
    "lidar-1440": "{lidar: scan, beams: 1440, fov_deg: 360, rate_hz: 25, noise: {range: 0.01}}",
    "lidar3d": "{lidar3d: top, preset: velodyne-vlp16, at: [0, 0, 1], rate_hz: 25, columns: 720}",
    "beacons": "{beacons: ring, rate_hz: 25, noise: {range: 0.05, bearing_deg: 1}}",
    "imu": "{imu: feel}",
    "camera": f"{{{CLEAN}}}",
    "camera-noise": f"{{{CAMERA}, noise: 2}}",
    "camera-fisheye": f"{{{CLEAN}, fov_deg: 120, lens: {{fisheye: [0, 0, 0, 0]}}}}",
    "camera-depth": f"{{{CLEAN}, depth: true}}",
    "camera-segments": f"{{{CLEAN}, segmentation: true}}",
    "camera-high": f"{{{CLEAN}, quality: high}}",
}
"""Name of the figure -> the sensor, in the gallery; the ring and the bumper are there in any case."""


def look(sensor: str) -> Prepare:
    """Measure `Simulation.sense` of a robot with one sensor that is due at every tick [ms]."""

    @contextmanager
    def prepare() -> Iterator[Once]:
        world = gallery()
        text = format_world(world.model_copy(update={"robots": ()}))
        robot = f"{{name: scout, preset: pioneer3dx, at: [2.7, 1.9], heading_deg: 20, sensors: [{sensor}]}}"
        with Simulation(parse_world(f"{text}\nrobots: [{robot}]\n")) as sim:

            def once(clock: Clock) -> float:
                seconds = 0.0
                for _ in range(LOOKS):
                    sim.step()
                    began = clock()
                    sim.sense("scout")
                    seconds += clock() - began
                return 1e3 * seconds / LOOKS

            once(perf_counter)
            yield once

    return prepare


SENSOR_FIGURES = tuple(Figure(f"sense-{name}", "ms a look", look(sensor)) for name, sensor in SENSORS.items())
