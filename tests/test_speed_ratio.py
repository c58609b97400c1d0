"""Speed that must not be lost: what a picture draws, and what a tick costs against the least that it can.

A picture costs its pixels and about 20 microseconds a geom that is drawn, so these are counted; `mjsim bench` tells its
time. A tick is measured in processor time beside its least, in turns: no figure here depends on how fast the machine
is. The ratio may be worse than it was when it was written down by what makes a figure fall by 30 %.
"""

from collections.abc import Callable
from time import process_time

import mujoco
import numpy as np
import pytest

from mjsim.bench.figure import Once
from mjsim.bench.scenes import LIDAR, gallery, gallery_places, hall, office, office_places
from mjsim.geometry import Pose
from mjsim.run import Driver, ticks
from mjsim.sim import Renderer, Simulation
from mjsim.sim.rendering.in_view import InView

pytestmark = pytest.mark.slow

ROUNDS, KEPT = 12, 0.7
"""How often each is measured; what share of a figure must be kept."""
WIDTH, HEIGHT, WALLS = 32, 24, 500
DRAWN = 16
"""Geoms in a picture, of 80 in the gallery and more than 1000 in an office."""
LOOP = 2.9
"""What a tick with a lidar costs, in its physics and rays."""


def times_the_floor(ours: Once, floor: Once) -> float:
    """Return how many times the cost of its floor a figure costs, both of them given as speeds.

    What is slower is slower in every round; what else the machine does disturbs some. So a low one counts.
    """
    return sorted(floor(process_time) / ours(process_time) for _ in range(ROUNDS))[1]


def most_drawn(sim: Simulation, places: list[Pose]) -> int:
    """Return how many geoms are drawn in the picture that shows most."""
    counts = []
    with Renderer(sim.model, width=WIDTH, height=HEIGHT) as renderer:
        for place in places:
            sim.move("scout", place)
            renderer.render(sim.data, "scout/front")
            counts.append(renderer.drawn)
    return max(counts)


def test_a_picture_draws_few_things_in_a_gallery_and_in_an_office():
    for world, places in ((gallery(), gallery_places(12)), (office(WALLS, WIDTH, HEIGHT), office_places(WALLS, 12))):
        with Simulation(world) as sim:
            assert most_drawn(sim, places) < DRAWN


def test_an_office_drawn_wall_by_wall_is_caught(monkeypatch):
    with Simulation(office(WALLS, WIDTH, HEIGHT)) as sim:
        # Its walls seen as the boxes that they are for the physics.
        groups, boxes = sim.model.geom_group, sim.model.geom_type == mujoco.mjtGeom.mjGEOM_BOX
        meshes = sim.model.geom_type == mujoco.mjtGeom.mjGEOM_MESH
        groups[meshes], groups[boxes & (groups == 3)] = 3, 1
        monkeypatch.setattr(InView, "unseen", lambda self, data, view: np.empty(0, dtype=int))
        assert most_drawn(sim, office_places(WALLS, 2)) > 30 * DRAWN


def test_a_tick_with_a_lidar_costs_little_more_than_its_physics_and_its_rays():
    with Simulation(hall(LIDAR.replace("12.5", "25"))) as sim:
        loop = ticks(sim, {"scout0": Driver()})
        next(loop)
        angles = np.linspace(-np.pi / 2, np.pi / 2, 180 + 16)
        rays = np.stack([np.cos(angles), np.sin(angles), np.zeros(len(angles))], axis=1).ravel()
        groups = np.array([1, 0, 0, 1, 0, 0], dtype=np.uint8)
        geoms, far = np.empty(len(angles), dtype=np.int32), np.empty(len(angles))

        def bare(clock: Callable[[], float]) -> float:
            began = clock()
            for _ in range(50):
                mujoco.mj_step(sim.model, sim.data, sim.world.run.steps_per_tick)
                start = sim.data.xpos[1] + [0.0, 0.0, 0.3]
                mujoco.mj_multiRay(
                    sim.model, sim.data, start, rays, groups, True, 1, geoms, far, None, len(angles), 10.0
                )
            return 50 / (clock() - began)

        def ours(clock: Callable[[], float]) -> float:
            began = clock()
            for _ in range(50):
                next(loop)
            return 50 / (clock() - began)

        assert times_the_floor(ours, bare) < LOOP / KEPT
