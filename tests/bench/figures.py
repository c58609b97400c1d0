"""What is measured: each figure gets ready once, then gives one value a run."""

import math
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from importlib import resources
from pathlib import Path

import mujoco
import numpy as np
from threadpoolctl import threadpool_limits

from mjsim.algorithms.ekf_slam import EkfSlamFilter, odometry_motion
from mjsim.bench.large import large
from mjsim.record import read_recording
from mjsim.run import Driver, drivers_of, run, ticks
from mjsim.sim import Simulation
from mjsim.sim.opengl import make_context
from mjsim.sim.renderer import Renderer
from mjsim.world import World, load_world, parse_world

Once = Callable[[], float]


@dataclass(frozen=True)
class Figure:
    """One figure of the table."""

    name: str
    unit: str
    prepare: Callable[[], AbstractContextManager[Once]]
    """Gets ready; what it gives is called once a run and returns the value."""


def gallery() -> World:
    """Return the shipped gallery."""
    return load_world(Path(str(resources.files("mjsim.worlds") / "gallery.yaml")))


def hall(sensors: str = "", *, robots: int = 1) -> World:
    """Return a hall with 100 walls and robots with some sensors."""
    walls = [f"{{points: [[{x}, {y}], [{x + 1}, {y + 0.5}]]}}" for x in range(-20, 20, 4) for y in range(1, 21, 2)]
    team = [
        f"{{name: scout{k}, preset: pioneer3dx, at: [{4 * (k % 4)}, {-3 * (k // 4)}], sensors: [{sensors}]}}"
        for k in range(robots)
    ]
    return parse_world(f"mjsim: 1\nname: hall\nwalls: [{', '.join(walls)}]\nrobots: [{', '.join(team)}]\n")


def loop_speed(world: World, *, seconds: float) -> Callable[[], AbstractContextManager[Once]]:
    """Measure the loop with physics and sensing and no modules."""

    @contextmanager
    def prepare() -> Iterator[Once]:
        with Simulation(world) as sim:
            loop = ticks(sim, {robot.name: Driver() for robot in world.robots})
            next(loop)
            count = round(seconds / sim.dt)

            def once() -> float:
                began = time.perf_counter()
                for _ in range(count):
                    next(loop)
                return seconds / (time.perf_counter() - began)

            yield once

    return prepare


@contextmanager
def whole_run() -> Iterator[Once]:
    """Measure the gallery with recognition, SLAM, navigation and recording."""
    world, seconds = gallery(), 10.0

    def once() -> float:
        with Simulation(world) as sim, tempfile.TemporaryDirectory() as folder:
            drivers = drivers_of(world)
            began = time.perf_counter()
            run(sim, drivers=drivers, seconds=seconds, record=Path(folder) / "run.mcap")
            return seconds / (time.perf_counter() - began)

    yield once


@contextmanager
def pictures() -> Iterator[Once]:
    """Measure pictures of the gallery, turning on the spot."""
    with Simulation(gallery()) as sim, Renderer(sim.model, width=640, height=480) as renderer:
        heading = sim.model.joint("scout/free").qposadr[0] + 3

        def once() -> float:
            began = time.perf_counter()
            for angle in np.linspace(0.0, np.pi, 40, endpoint=False):
                sim.data.qpos[heading : heading + 4] = [math.cos(angle), 0.0, 0.0, math.sin(angle)]
                mujoco.mj_kinematics(sim.model, sim.data)
                mujoco.mj_camlight(sim.model, sim.data)
                renderer.render(sim.data, "scout/front")
            return 40 / (time.perf_counter() - began)

        yield once


QUAD = """
<mujoco>
  <visual><global offwidth="640" offheight="480"/><quality shadowsize="0" offsamples="0"/></visual>
  <asset>
    <texture name="t" type="2d" builtin="checker" width="512" height="512" rgb1="0.2 0.3 0.4" rgb2="0.8 0.7 0.6"/>
    <material name="m" texture="t"/>
  </asset>
  <worldbody>
    <geom type="plane" size="10 10 1" material="m"/>
    <camera name="c" pos="0 0 1"/>
  </worldbody>
</mujoco>
"""


@contextmanager
def picture_floor() -> Iterator[Once]:
    """Measure the least that a picture can cost: one textured quad that fills it, drawn and read back raw."""
    model = mujoco.MjModel.from_xml_string(QUAD)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    context = make_context(640, 480)
    context.make_current()
    mjr = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_50)
    mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, mjr)
    scene, camera = mujoco.MjvScene(model, 1), mujoco.MjvCamera()
    camera.type, camera.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, 0
    mujoco.mjv_updateScene(model, data, mujoco.MjvOption(), None, camera, mujoco.mjtCatBit.mjCAT_ALL, scene)
    scene.flags[:] = 0
    rect, rgb = mujoco.MjrRect(0, 0, 640, 480), np.empty((480, 640, 3), np.uint8)

    def once() -> float:
        context.make_current()
        began = time.perf_counter()
        for _ in range(40):
            mujoco.mjr_render(rect, scene, mjr)
            mujoco.mjr_readPixels(rgb, None, rect, mjr)
        seconds = time.perf_counter() - began
        context.release()
        return 40 / seconds

    yield once
    context.make_current()
    mjr.free()
    context.free()


def filter_time(landmarks: int) -> Callable[[], AbstractContextManager[Once]]:
    """Measure one predict and one update with 10 sightings, on one BLAS thread."""

    @contextmanager
    def prepare() -> Iterator[Once]:
        rng = np.random.default_rng(0)
        places = rng.uniform(-10.0, 10.0, (landmarks, 2))
        slam, motion = EkfSlamFilter(jacobians="first-estimates"), odometry_motion()
        noise = np.diag([0.01, 0.01]) ** 2

        def look(names: np.ndarray) -> None:
            ahead = places[names]
            z = np.column_stack([np.hypot(*ahead.T), np.arctan2(ahead[:, 1], ahead[:, 0])])
            slam.update(names.tolist(), z, noise)

        look(np.arange(landmarks))

        def once() -> float:
            with threadpool_limits(1, user_api="blas"):
                began = time.perf_counter()
                for _ in range(50):
                    slam.predict(motion, np.zeros(3), np.eye(3) * 1e-6)
                    look(rng.choice(landmarks, 10, replace=False))
                return 1e3 * (time.perf_counter() - began) / 50

        yield once

    return prepare


@contextmanager
def film() -> Iterator[Once]:
    """Measure the video of a short gallery run: drawing and encoding."""
    from mjsim.video import make_video

    world = gallery()
    with tempfile.TemporaryDirectory() as folder:
        with Simulation(world) as sim:
            run(sim, seconds=6.0, record=Path(folder) / "run.mcap")
        recording = read_recording(Path(folder) / "run.mcap")

        def once() -> float:
            began = time.perf_counter()
            make_video(recording, Path(folder) / "run.mp4")
            return len(recording.time) / (time.perf_counter() - began)

        yield once


LIDAR = "{lidar: scan, beams: 180, rate_hz: 12.5, noise: {range: 0.01}}"
PACE = "simulated seconds a second"
LARGE = (1000, 3000, 10_000)
"""Wall segments."""
FIGURES = (
    Figure("loop", PACE, loop_speed(hall(), seconds=4.0)),
    Figure("loop-lidar", PACE, loop_speed(hall(LIDAR), seconds=4.0)),
    Figure("loop-8-lidars", PACE, loop_speed(hall(LIDAR, robots=8), seconds=2.0)),
    Figure("loop-camera", PACE, loop_speed(hall("{camera: front}"), seconds=2.0)),
    Figure("gallery", PACE, whole_run),
    Figure("pictures-640x480", "pictures a second", pictures),
    Figure("pictures-floor", "pictures a second", picture_floor),
    Figure("filter-10", "ms a predict and update", filter_time(10)),
    Figure("filter-100", "ms a predict and update", filter_time(100)),
    Figure("film", "frames a second", film),
    *(Figure(f"large-{n}", "s to be made ready", large(n, memory=False)) for n in LARGE),
    *(Figure(f"large-{n}-memory", "MB at most", large(n, memory=True)) for n in LARGE),
)
"""In the order in which they are printed."""
