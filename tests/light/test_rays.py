"""Rays and the light of lamps against sums over small parts."""

import io

import numpy as np
import pytest

from mjsim.light.emitters import lamp_color, lamp_rectangle, sky_share
from mjsim.light.light_rays import Points, Rectangle, Room, buried_share, hemisphere, light_of, uniform
from mjsim.light.work import Surroundings, lit, received, send, serve
from mjsim.world import Lamp

UP = np.array([0.0, 0.0, 1.0])


def square(middle, across, along):
    """Return the two triangles of a rectangle, shape (2, 3, 3)."""
    a, b = np.asarray(across, float), np.asarray(along, float)
    corners = np.asarray(middle, float) + np.array([-a - b, a - b, a + b, b - a])
    return corners[np.array([[0, 1, 2], [0, 2, 3]])]


def points_at(points, normals):
    normals = np.asarray(normals, float)
    return Points(np.arange(len(points)), np.asarray(points, float), normals / np.linalg.norm(normals, axis=1)[:, None])


def direct(rectangle, at, hidden=lambda starts, ends: False, steps=60):
    """Return the light of small parts of a rectangle by Lambert's law, shape (n,)."""
    share = (np.arange(steps) + 0.5) * 2 / steps - 1
    u, v = (each.ravel()[:, None] for each in np.meshgrid(share, share))
    parts = rectangle.middle + u * rectangle.across + v * rectangle.along
    light = []
    for point, normal in zip(at.points, at.normals, strict=True):
        to = parts - point
        distance = np.linalg.norm(to, axis=1)
        cosines = np.clip(to @ normal, 0, None) * np.clip(-(to @ rectangle.outward), 0, None) / distance**2
        light.append((cosines / distance**2 * ~np.array(hidden(point, parts))).sum())
    return rectangle.radiance * rectangle.area / steps**2 * np.array(light)


LAMP_AT_2 = Rectangle(np.array([0.2, 0.1, 2.0]), np.array([0.3, 0.1, 0.0]), np.array([0.1, -0.3, 0.0]), 1.7)
NOTHING = Room(square([90, 0, 0], [0, 1, 0], [0, 0, 1]).astype(np.float32))


def test_light_of_a_lamp_is_the_sum_over_its_parts_also_where_the_horizon_cuts_it():
    rng = np.random.default_rng(0)
    at = points_at(rng.uniform((-2, -2, 0), (2, 2, 1), (30, 3)), rng.normal((0, 0, 1), 0.6, (30, 3)))
    exact = direct(LAMP_AT_2, at)
    np.testing.assert_allclose(light_of(NOTHING, at, LAMP_AT_2), exact, rtol=0.02, atol=3e-3)
    above = points_at(at.points + 2.1 * UP, -at.normals)
    assert not light_of(NOTHING, above, LAMP_AT_2).any()
    np.testing.assert_allclose(LAMP_AT_2.outward, -UP, atol=1e-12)
    assert LAMP_AT_2.area == pytest.approx(4 * 0.1)
    colors = np.array([[1.0, 0.5], [0.0, 2.0]], np.float32)
    around = Surroundings(NOTHING, np.zeros(2, np.int64), None, None)
    both = lit(around, at, [LAMP_AT_2, LAMP_AT_2], colors)
    np.testing.assert_allclose(both, light_of(NOTHING, at, LAMP_AT_2)[:, None] * [1.0, 2.5], rtol=1e-5)


def test_a_board_shades_the_part_of_a_lamp_that_it_hides():
    board = Room(square([0.4, 0.0, 1.0], [0.3, 0, 0], [0, 0.3, 0]).astype(np.float32))
    at = points_at([[x, 0.05 * x, 0] for x in np.linspace(-1.5, 1.5, 16)], np.tile(UP, (16, 1)))

    def hidden(start, ends):
        middle = (start + ends) / 2 + (ends - start) * ((1 - start[2]) / (ends[:, 2:] - start[2]) - 0.5)
        return (np.abs(middle[:, :2] - (0.4, 0)) < 0.3).all(axis=1)

    exact = direct(LAMP_AT_2, at, hidden)
    np.testing.assert_allclose(light_of(board, at, LAMP_AT_2), exact, atol=0.02)
    assert light_of(board, at, LAMP_AT_2).min() == 0.0


def test_a_lamp_is_in_full_light_two_metres_below_it():
    lamp = lamp_rectangle(Lamp(at=(0.5, 1.0), height=2.0))
    assert direct(lamp, points_at([[0.5, 1.0, 0.0]], [UP]))[0] == pytest.approx(1.0, rel=1e-4)
    assert lamp.outward.tolist() == [0, 0, -1]
    np.testing.assert_allclose(lamp_color("#ff8000"), [1.0, (128 / 255) ** 2.2, 0.0])


def test_rays_of_a_hemisphere_are_unit_vectors_that_crowd_about_the_normal_by_the_cosine():
    at = points_at(np.zeros((3, 3)), [[0.0, 0.0, 1.0], [1.0, 2.0, 3.0], [-1.0, 0.1, 0.0]])
    rays = np.array(list(hemisphere(at, 20)))
    np.testing.assert_allclose(np.linalg.norm(rays, axis=2), 1.0, atol=1e-5)
    cosines = np.einsum("rnj,nj->rn", rays, at.normals)
    assert cosines.min() > 0.0
    # Of a density cos / pi the mean of the cosine is 2/3, of its square 1/2; aside the mean is 0.
    np.testing.assert_allclose(cosines.mean(axis=0), 2 / 3, atol=0.005)
    np.testing.assert_allclose((cosines**2).mean(axis=0), 1 / 2, atol=0.005)
    np.testing.assert_allclose(rays.mean(axis=0), at.normals * 2 / 3, atol=0.01)
    numbers = uniform(np.arange(4000), 3)
    assert (numbers.min() >= 0, numbers.max() < 1) == (True, True)
    np.testing.assert_allclose(np.histogram(numbers, 10, (0, 1))[0], 400, atol=80)
    assert abs(np.corrcoef(numbers, uniform(np.arange(4000), 4))[0, 1]) < 0.05


def mixed(number, stream):
    """Return SplitMix64 of Python's whole numbers, its upper 24 bits."""
    mask = (1 << 64) - 1
    z = ((number << 16) + stream + 1) * 0x9E3779B97F4A7C15 & mask
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9 & mask
    z = (z ^ z >> 27) * 0x94D049BB133111EB & mask
    return ((z ^ z >> 31) >> 40) / 2**24


def test_random_numbers_are_those_of_splitmix():
    numbers = [0, 1, 77, 1 << 40]
    assert uniform(np.array(numbers), 1001).tolist() == [mixed(number, 1001) for number in numbers]


def test_points_in_a_box_or_a_narrow_gap_are_buried():
    box = np.concatenate([square(side, *rest) for side, rest in zip(
        [[0, 0, 1], [0, 0, 0]], [([1, 0, 0], [0, 1, 0]), ([1, 0, 0], [0, -1, 0])], strict=True)])  # fmt: skip
    room = Room(box.astype(np.float32))
    at = points_at([[0, 0, 0.5], [0, 0, 2], [0, 0, 1.05], [0, 0, 1.0]], [UP, UP, -UP, UP])
    inside, above, near, on = buried_share(room, at, 4).tolist()
    assert inside > 0.6
    assert (above, near, on) == (0.0, pytest.approx(1.0, abs=0.7), 0.0)
    assert near > 0.3
    shares = sky_share(room, np.array([[0, 0, 2.0], [0, 0, 2.0], [0, 0, 0.5]]), np.array([UP, [1.0, 0, 0], UP]))
    np.testing.assert_allclose(shares[:2], [1.0, 0.5], atol=0.03)
    assert shares[2] < 0.4


def test_work_and_its_results_pass_through_pipes():
    at = points_at([[0.0, 0.0, 0.0]], [UP])
    requests, answers = io.BytesIO(), io.BytesIO()
    for sent in (Surroundings(Room(NOTHING.corners), np.zeros(2, np.int64), None, None), None):
        send(requests, ("buried", sent, at, (2,)))
    requests.seek(0)
    serve(requests, answers)
    answers.seek(0)
    assert [received(answers).tolist() for _ in range(2)] == [[0.0], [0.0]]
    with pytest.raises(EOFError):
        received(io.BytesIO(requests.getvalue()[:20]))
