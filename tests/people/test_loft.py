"""Surfaces through rings: volumes and extents of cylinders, cones and domes."""

import math

import numpy as np
import pytest

from mjsim.people.loft import Ring, loft


@pytest.mark.parametrize(("start", "end"), [(0.1, 0.3), (0.02, 0.02)])
def test_equal_rings_are_a_cylinder_between_half_ellipsoids_whichever_end_comes_first(start, end):
    rings = [Ring(0.0, 0.2, 0.2, 0.2), Ring(0.3, 0.2, 0.2, 0.2), Ring(0.5, 0.2, 0.2, 0.2)]
    whole = math.pi * 0.2**2 * (0.5 + 2.0 / 3.0 * (start + end))
    for mesh in (loft(rings, start=start, end=end), loft(rings[::-1], start=end, end=start)):
        # Polygons of some twenty corners hold a few percent less.
        assert 0.92 * whole < mesh.volume() < whole
        assert mesh.vertices[:, 2].min() == pytest.approx(-start)
        assert mesh.vertices[:, 2].max() == pytest.approx(0.5 + end)
        away = np.hypot(mesh.vertices[:, 0], mesh.vertices[:, 1])
        below = mesh.vertices[:, 2] < -1e-9
        np.testing.assert_allclose((away[below] / 0.2) ** 2 + (mesh.vertices[below, 2] / start) ** 2, 1.0, atol=1e-3)


def test_an_oval_reaches_as_far_to_each_side_as_its_ring_says_and_bends_smoothly_between():
    rings = [Ring(0.0, 0.3, 0.1, 0.2, 0.05), Ring(1.0, 0.15, 0.1, 0.2, 0.05, square=4.0)]
    mesh = loft(rings, start=0.01, end=0.01)
    low = mesh.vertices[np.isclose(mesh.vertices[:, 2], 0.0)]
    np.testing.assert_allclose(
        [low[:, 0].max(), -low[:, 0].min(), low[:, 1].max(), -low[:, 1].min()], [0.3, 0.1, 0.2, 0.05]
    )
    fronts = [ring[:, 0].max() for ring in np.split(mesh.vertices, np.flatnonzero(np.diff(mesh.vertices[:, 2])) + 1)]
    assert max(fronts) == pytest.approx(0.3)
    middle = mesh.vertices[np.isclose(mesh.vertices[:, 2], 0.5)]
    assert middle[:, 0].max() == pytest.approx(0.225, abs=1e-6), "halfway between both"
