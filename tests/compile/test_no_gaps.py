"""A lidar of 180 beams swept along every wall of every shipped world: no beam passes where the plan has a wall."""

from importlib import resources
from pathlib import Path

import mujoco
import numpy as np
import pytest
import shapely
from numpy.typing import NDArray

from mjsim.bench.rooms import cast, forwarded
from mjsim.compile import compile_world
from mjsim.world import World, load_world, parse_world, segments, solid

WORLDS = Path(str(resources.files("mjsim.worlds")))
ALIKE = {"office", "museum", "warehouse"}
"""Large worlds whose walls meet as those of others do; that all boxes are the plan's is tested on random rooms."""
QUICK = ("arena", "corridor", "ramps")
NAMES = [
    pytest.param(path.stem, marks=() if path.stem in QUICK else pytest.mark.slow)
    for path in sorted(WORLDS.glob("*.yaml"))
    if "walls:" in path.read_text() and path.stem not in ALIKE
]
HEIGHT, BEAMS = 0.3, 180
STEP, OFF = 0.5, 0.05
"""From one place of the lidar to the next, and from the face to the lidar [m]."""
SKIN = 1e-3
"""A beam may go so far into a wall [m]: pieces of walls are rounded to the micrometre, rays are not."""


def places_along(walls: World) -> NDArray[np.float64]:
    """Return places beside all faces of walls, also beside their ends, shape (n, 2) [m]."""
    places = []
    for start, end in segments(walls, height=HEIGHT):
        length = np.linalg.norm(end - start)
        along = (end - start) / length
        steps = np.linspace(0.0, length, int(length / STEP) + 2)
        places.append(start + along * steps[:, None] + OFF * np.array([along[1], -along[0]]))
    found = np.concatenate(places) if places else np.zeros((0, 2))
    # At an inner corner a place may lie in the next face.
    return found[~shapely.contains_xy(solid(walls, height=HEIGHT).buffer(OFF / 5), *found.T)]


def beams_that_pass(world: World, model: mujoco.MjModel) -> tuple[int, int]:
    """Return how many beams were cast along the walls of a world, and how many of them passed through one."""
    data, walls = forwarded(model), World(walls=world.walls)
    inner = shapely.get_parts(solid(walls, height=HEIGHT).buffer(-SKIN, join_style="mitre"))
    tree, count, passed = shapely.STRtree(inner), 0, 0
    for number, place in enumerate(places_along(walls)):
        # Turned a little from place to place, so that beams go at all angles.
        angles = np.arange(BEAMS) * (2 * np.pi / BEAMS) + number * 0.0107
        beams = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(BEAMS)])
        ranges = np.minimum(cast(model, data, np.append(place, HEIGHT), beams), 200.0)
        ends = place + ranges[:, None] * beams[:, :2]
        lines = shapely.linestrings(np.stack([np.broadcast_to(place, ends.shape), ends], axis=1))
        passed += len(np.unique(tree.query(lines, predicate="intersects")[0]))
        count += BEAMS
    return count, passed


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_no_beam_passes_through_a_wall(name):
    world = load_world(WORLDS / f"{name}.yaml")
    count, passed = beams_that_pass(world, compile_world(World(walls=world.walls)).compile())
    assert count > 2 * BEAMS * sum(len(wall.segments()) for wall in world.walls)
    assert passed == 0


def test_a_gap_of_a_centimetre_would_be_found():
    world = parse_world("walls: [{points: [[0, 0], [3, 0]]}, {points: [[2, 2], [2, 0]]}]")
    model = compile_world(world).compile()
    assert beams_that_pass(world, model)[1] == 0
    # The second wall is made shorter at both ends, so that it no longer reaches the first.
    model.geom_size[model.geom("wall/2/0").id][0] -= 0.06
    assert beams_that_pass(world, model)[1] > 0
