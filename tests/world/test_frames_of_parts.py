"""Frames and shapes that a world file gives in degrees, or takes over from a preset."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mjsim.world import BoxBody, parse_world
from mjsim.world.plan.people_plan import look_beside, look_over


def test_another_shape_replaces_that_of_a_preset_and_keeps_its_mass():
    text = "mjsim: 1\nrobots: [{{name: r, preset: create3, at: [0, 0]{}}}]\n"
    plain, boxed = (parse_world(text.format(more)).robots[0].body for more in ("", ", body: {box: [0.5, 0.3, 0.2]}"))
    assert isinstance(boxed, BoxBody)
    assert (boxed.box, boxed.mass) == ((0.5, 0.3, 0.2), plain.mass)
    assert plain.look
    assert not boxed.look


@pytest.mark.parametrize("rpy", [(0.0, 0.0, 90.0), (30.0, -20.0, 70.0)])
def test_a_shape_of_a_mechanism_is_turned_by_degrees_about_the_fixed_axes_in_order(rpy):
    bar = f"{{name: bar, rod: [0.6, 0.02], at: [0.1, 0.2, 0.3], rpy_deg: {list(rpy)}}}"
    joint = "{revolute: q, of: [ground, bar], axis: [0, 1, 0]}"
    world = parse_world(f"mjsim: 1\nmechanisms: [{{name: m, at: [0, 0], bodies: [{bar}], joints: [{joint}]}}]\n")
    body = world.mechanisms[0].bodies[0]
    turned = Rotation.from_euler("xyz", rpy, degrees=True)
    np.testing.assert_allclose(body.frame()[:3, :3], turned.as_matrix(), atol=1e-12)
    np.testing.assert_allclose(body.frame()[:3, 3], [0.1, 0.2, 0.3])
    points, radius = body.spans()
    hull, same = body.hull()
    assert radius == same
    np.testing.assert_allclose(hull, turned.apply(points) + body.at, atol=1e-12)
    for name, at in body.ends().items():
        np.testing.assert_allclose(body.points()[name], turned.apply(at) + body.at, atol=1e-12)


def test_a_person_is_drawn_from_the_right_and_from_above_whichever_way_it_faces():
    for heading in (0.0, 0.7, -2.5):
        turned = Rotation.from_euler("z", heading)
        pelvis = np.eye(4)
        # Bent forward a little: its left stays level.
        pelvis[:3, :3] = (turned * Rotation.from_euler("y", 0.3)).as_matrix()
        pelvis[:3, 3] = [2.0, 1.0, 0.9]
        ahead, left, up = (turned.apply(axis) for axis in np.eye(3))
        place = np.array([2.0, 1.0, 0.0]) + 0.4 * ahead + 0.1 * left + 1.2 * up
        beside, over = (look({"pelvis": pelvis}) @ [*place, 1.0] for look in (look_beside, look_over))
        np.testing.assert_allclose(beside, [0.4, 1.2, -0.1], atol=1e-12)
        np.testing.assert_allclose(over, [0.4, 0.1, 1.2], atol=1e-12)
