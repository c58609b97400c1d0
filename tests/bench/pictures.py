"""Pictures a second: through the simulation, at the least that a picture can cost, and as stock MuJoCo draws them."""

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from time import perf_counter

import mujoco
import numpy as np

from mjsim.bench.figure import Clock, Once, Prepare
from mjsim.bench.naive import naive_scene, put, stock_renderer
from mjsim.bench.scenes import gallery, gallery_places, gallery_with, office, office_places
from mjsim.geometry import Pose
from mjsim.sim import Renderer, Simulation, make_context
from mjsim.world import World

LAMPS = ((4.0, 5.0), (10.0, 5.0))
"""Of the gallery written naively: one a room, world frame [m]."""
BARE = '<quality shadowsize="0" offsamples="0"/>'
"""Neither shadows nor several samples a pixel."""
QUAD = """
<mujoco>
  <visual><global offwidth="{width}" offheight="{height}"/><quality shadowsize="0" offsamples="0"/></visual>
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
def pictures() -> Iterator[Once]:
    """Measure pictures of the gallery, turning on the spot."""
    with Simulation(gallery()) as sim, Renderer(sim.model, width=640, height=480) as renderer:
        heading = sim.model.joint("scout/free").qposadr[0] + 3

        def once(clock: Clock) -> float:
            began = clock()
            for angle in np.linspace(0.0, np.pi, 40, endpoint=False):
                sim.data.qpos[heading : heading + 4] = [math.cos(angle), 0.0, 0.0, math.sin(angle)]
                mujoco.mj_kinematics(sim.model, sim.data)
                mujoco.mj_camlight(sim.model, sim.data)
                renderer.render(sim.data, "scout/front")
            return 40 / (clock() - began)

        yield once


def sensed(make: Callable[[], World], places: Callable[[], Sequence[Pose]]) -> Prepare:
    """Measure `Simulation.sense` of a robot whose camera gives a picture each time: pictures a second."""

    @contextmanager
    def prepare() -> Iterator[Once]:
        with Simulation(make()) as sim:
            (robot,), looked = sim.robots, places()

            def once(clock: Clock) -> float:
                seconds = 0.0
                for place in looked:
                    sim.step()
                    sim.move(robot, place)
                    began = clock()
                    sim.sense(robot)
                    seconds += clock() - began
                return len(looked) / seconds

            once(perf_counter)  # The first pictures copy textures to where they are drawn, and compile what draws.
            yield once

    return prepare


def gallery_sensed(width: int, height: int, *, places: int = 40, **keys: object) -> Prepare:
    """Measure `Simulation.sense` in the gallery, from so many places."""
    return sensed(lambda: gallery_with(width, height, **keys), lambda: gallery_places(places))


def office_sensed(segments: int, width: int = 640, height: int = 480) -> Prepare:
    """Measure `Simulation.sense` in a large office."""
    return sensed(lambda: office(segments, width, height), lambda: office_places(segments))


def picture_floor(width: int, height: int) -> Prepare:
    """Measure the least that a picture can cost: one textured quad that fills it, drawn and read back raw."""

    @contextmanager
    def prepare() -> Iterator[Once]:
        model = mujoco.MjModel.from_xml_string(QUAD.format(width=width, height=height))
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        with raw(model, width=width, height=height) as (scene, draw):
            scene.flags[:] = 0
            camera = fixed_camera()
            everything = mujoco.mjtCatBit.mjCAT_ALL
            mujoco.mjv_updateScene(model, data, mujoco.MjvOption(), None, camera, everything, scene)

            def once(clock: Clock) -> float:
                return 40 / draw(clock, lambda: None, 40)

            once(perf_counter)
            yield once

    return prepare


@contextmanager
def raw(
    model: mujoco.MjModel, *, width: int, height: int
) -> Iterator[tuple[mujoco.MjvScene, Callable[[Clock, Callable[[], None], int], float]]]:
    """Give a scene, and what draws it with MuJoCo's bare functions.

    That is called with a clock, what fills the scene, and how often; it returns how long it took [s].
    """
    context = make_context(width, height)
    context.make_current()
    mjr = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_50)
    mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, mjr)
    context.release()
    scene = mujoco.MjvScene(model, model.ngeom)
    rect, rgb = mujoco.MjrRect(0, 0, width, height), np.empty((height, width, 3), np.uint8)

    def draw(clock: Clock, fill: Callable[[], None], times: int) -> float:
        context.make_current()
        began = clock()
        for _ in range(times):
            fill()
            mujoco.mjr_render(rect, scene, mjr)
            mujoco.mjr_readPixels(rgb, None, rect, mjr)
        seconds = clock() - began
        context.release()
        return seconds

    yield scene, draw
    context.make_current()
    mjr.free()
    context.free()


def fixed_camera() -> mujoco.MjvCamera:
    """Return the view of the first camera of a model."""
    camera = mujoco.MjvCamera()
    camera.type, camera.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, 0
    return camera


def stock(width: int, height: int) -> Prepare:
    """Measure `mujoco.Renderer` as it is, in the gallery written naively."""

    @contextmanager
    def prepare() -> Iterator[Once]:
        model = naive_scene(gallery(), width=width, height=height, lamps=LAMPS)
        data, places = mujoco.MjData(model), gallery_places()[::10]
        with stock_renderer(model, width=width, height=height) as renderer:

            def once(clock: Clock) -> float:
                seconds = 0.0
                for place in places:
                    put(model, data, place)
                    began = clock()
                    renderer.update_scene(data, "front")
                    renderer.render()
                    seconds += clock() - began
                return len(places) / seconds

            once(perf_counter)
            yield once

    return prepare


@contextmanager
def stock_compiled() -> Iterator[Once]:
    """Measure `mujoco.Renderer` as it is, in the gallery as mjsim compiles it."""
    with Simulation(gallery()) as sim, stock_renderer(sim.model, width=640, height=480) as renderer:
        (robot,), places = sim.robots, gallery_places()

        def once(clock: Clock) -> float:
            seconds = 0.0
            for place in places:
                sim.move(robot, place)
                mujoco.mj_forward(sim.model, sim.data)
                began = clock()
                renderer.update_scene(sim.data, f"{robot}/front")
                renderer.render()
                seconds += clock() - began
            return len(places) / seconds

        once(perf_counter)
        yield once


def office_geom_by_geom(segments: int, width: int = 640, height: int = 480) -> Prepare:
    """Measure the office drawn geom by geom with MuJoCo's bare functions: no shadows, one sample a pixel."""

    @contextmanager
    def prepare() -> Iterator[Once]:
        world = office(segments, width, height)
        model = naive_scene(world, width=width, height=height, lamps=(), visual=BARE)
        data, option, camera = mujoco.MjData(model), mujoco.MjvOption(), fixed_camera()
        with raw(model, width=width, height=height) as (scene, draw):
            scene.flags[:] = 0
            scene.flags[mujoco.mjtRndFlag.mjRND_CULL_FACE] = 1
            places = office_places(segments)[::4]

            def fill() -> None:
                mujoco.mjv_updateScene(model, data, option, None, camera, mujoco.mjtCatBit.mjCAT_ALL, scene)

            def once(clock: Clock) -> float:
                seconds = 0.0
                for place in places:
                    put(model, data, place)
                    seconds += draw(clock, fill, 1)
                return len(places) / seconds

            once(perf_counter)
            yield once

    return prepare
