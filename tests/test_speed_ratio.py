"""Speed that must not be lost: what pictures and ticks cost, against the least that they can on the same machine.

Both are measured in turns, in processor time, and only their ratio counts: no figure here depends on how fast the
machine is. A ratio may be worse than it was when it was written down by what makes a figure fall by 30 %.
"""

from collections.abc import Callable
from time import process_time

import mujoco
import numpy as np
import pytest

from mjsim.bench.figure import Once
from mjsim.bench.pictures import gallery_sensed, picture_floor
from mjsim.bench.scenes import LIDAR, hall, office, office_places
from mjsim.run import Driver, ticks
from mjsim.sim import Renderer, Simulation
from mjsim.sim.rendering.in_view import InView

pytestmark = pytest.mark.slow

ROUNDS, KEPT = 6, 0.7
"""How often each is measured; what share of a figure must be kept."""
WIDTH, HEIGHT, WALLS = 320, 240, 500
GALLERY, OFFICE, LOOP = 1.95, 1.75, 2.9
"""What a picture of the gallery and of an office cost, in floors, and a tick with a lidar in its physics and rays."""


def times_the_floor(ours: Once, floor: Once) -> float:
    """Return how many times the cost of its floor a figure costs, both of them given as speeds.

    What is slower is slower in every round; what else the machine does disturbs some. So a low one counts.
    """
    return sorted(floor(process_time) / ours(process_time) for _ in range(ROUNDS))[1]


def drawn(renderer: Renderer, sim: Simulation) -> Once:
    """Return what measures pictures of an office."""

    def once(clock: Callable[[], float]) -> float:
        seconds = 0.0
        places = office_places(WALLS, 12)
        for place in places:
            sim.move("scout", place)
            began = clock()
            renderer.render(sim.data, "scout/front")
            seconds += clock() - began
        return len(places) / seconds

    once(process_time)
    return once


def test_a_picture_of_the_gallery_costs_little_more_than_its_pixels():
    with picture_floor(WIDTH, HEIGHT)() as floor, gallery_sensed(WIDTH, HEIGHT)() as ours:
        assert times_the_floor(ours, floor) < GALLERY / KEPT


def test_a_picture_of_an_office_costs_as_one_of_a_room_and_drawing_wall_by_wall_is_caught(monkeypatch):
    with Simulation(office(WALLS, WIDTH, HEIGHT)) as sim, picture_floor(WIDTH, HEIGHT)() as floor:
        with Renderer(sim.model, width=WIDTH, height=HEIGHT) as renderer:
            assert times_the_floor(drawn(renderer, sim), floor) < OFFICE / KEPT
        # The same office, its walls seen as the boxes that they are for the physics.
        groups, boxes = sim.model.geom_group, sim.model.geom_type == mujoco.mjtGeom.mjGEOM_BOX
        meshes = sim.model.geom_type == mujoco.mjtGeom.mjGEOM_MESH
        groups[meshes], groups[boxes & (groups == 3)] = 3, 1
        monkeypatch.setattr(InView, "unseen", lambda self, data, view: np.empty(0, dtype=int))
        with Renderer(sim.model, width=WIDTH, height=HEIGHT) as naive:
            assert times_the_floor(drawn(naive, sim), floor) > OFFICE / KEPT


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
