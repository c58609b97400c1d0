"""Cylinders, boxes and polygons as bodies: where they bump and what their ring measures, held to shapely."""

import math

import numpy as np
import pytest
import shapely

from mjsim.sim import Simulation
from mjsim.world import parse_world

BODIES = {
    "radius: 0.3": shapely.Point(0, 0).buffer(0.3, quad_segs=2000),
    "box: [0.8, 0.5, 0.3]": shapely.box(-0.4, -0.25, 0.4, 0.25),
    "polygon: [[0.5, 0], [-0.2, 0.3], [-0.2, -0.3]]": shapely.Polygon([(0.5, 0), (-0.2, 0.3), (-0.2, -0.3)]),
}
ROOM = """
mjsim: 1
walls: [{points: [[-2, -2], [2, -2], [2, 2], [-2, 2]], closed: true, thickness: 0.2}]
robots: [{name: r, at: [%s, 0.3], heading_deg: 20, body: {%s}, proximity_range: 4}]
"""
INSIDE = shapely.box(-1.9, -1.9, 1.9, 1.9)


@pytest.mark.parametrize("body", BODIES)
def test_the_ring_measures_from_the_rim_of_its_shape_to_the_wall(body):
    with Simulation(parse_world(ROOM % (0.4, body))) as sim:
        seen = sim.sense("r").proximity
    for ray, told in enumerate(seen):
        angle = 2.0 * math.pi * ray / 16
        ends = [(0.0, 0.0), (9 * math.cos(angle), 9 * math.sin(angle))]
        rim = shapely.LineString(ends).intersection(BODIES[body]).length
        turned = shapely.affinity.rotate(shapely.LineString(ends), 20, origin=(0, 0))
        way = shapely.affinity.translate(turned, 0.4, 0.3).intersection(INSIDE).length
        assert told == pytest.approx(way - rim, abs=2e-3), ray


@pytest.mark.parametrize("body", BODIES)
def test_it_bumps_where_its_outline_reaches_the_wall_and_not_before(body):
    placed = shapely.affinity.rotate(BODIES[body], 20, origin=(0, 0))
    x = 1.9 - placed.bounds[2]
    # A bumper gives by a few millimetres: it feels what comes as near.
    for gap, touched in ((0.006, False), (0.0, True)):
        with Simulation(parse_world(ROOM % (x - gap, body))) as sim:
            assert bool(sim.sense("r").bump) == touched, gap
            if touched:
                corners = np.array(placed.exterior.coords)
                ahead = corners[corners[:, 0].argmax()]
                expected = math.atan2(ahead[1], ahead[0]) - math.radians(20)
                assert min(abs(bearing - expected) for bearing in sim.sense("r").bump) < 0.05
