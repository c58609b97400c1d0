"""What eyes see of a display: fields, what hides, and the same by another library's rays."""

import math

import mujoco
import numpy as np
import pytest

from mjsim.ergonomics import Eye, hiders, in_field, name_of, points_on, view_of
from mjsim.world import parse_world, placed_targets

WORLD = """
mjsim: 1
obstacles:
  - name: desk
    box: [0.2, 1.6, 0.8]
    at: [2, 0]
    targets: [{display: screen, at: [-0.3, 0, 1.2], size: [0.8, 0.4]}]
"""
"""The display hangs 0.3 m before the desk, facing back along x."""
SHADE = "  - {{name: shade, box: [0.02, {width}, 0.6], at: [0.85, {y}], elevation: 0.9}}\n"
"""Half way between the eyes and the display."""
HEAD = "  - {name: head, box: [0.1, 0.1, 0.1], at: [-3, 0], movable: true}\n"


def eye(side="left", *, place=(0.0, 0.0, 1.2), yaw=0.0):
    c, s = math.cos(yaw), math.sin(yaw)
    return Eye(side=side, place=np.array(place), axes=np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]))


def scene(more=""):
    from mjsim.compile import compile_world

    world = parse_world(WORLD + HEAD + more)
    model = compile_world(world).compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    (display,) = placed_targets(world)
    return model, data, display


def seen(more="", eyes=None):
    model, data, display = scene(more)
    return view_of(model, data, eyes or (eye("left"), eye("right")), display, head=model.body("obstacle/head").id)


@pytest.mark.parametrize(
    ("side", "azimuth", "elevation", "inside"),
    [
        ("left", 99.0, 0.0, True),
        ("left", 101.0, 0.0, False),
        ("left", -59.0, 0.0, True),
        ("left", -61.0, 0.0, False),
        ("right", -99.0, 0.0, True),
        ("right", 61.0, 0.0, False),
        ("left", 0.0, 59.0, True),
        ("left", 0.0, 61.0, False),
        ("right", 0.0, -74.0, True),
        ("right", 0.0, -76.0, False),
    ],
)
def test_a_field_ends_where_it_is_published_to_end(side, azimuth, elevation, inside):
    a, e = math.radians(azimuth), math.radians(elevation)
    ahead = np.array([[math.cos(e) * math.cos(a), math.cos(e) * math.sin(a), math.sin(e)]])
    assert in_field(eye(side), eye(side).place + 5.0 * ahead) == inside


def test_a_display_without_anything_before_it_is_seen_whole():
    view = seen()
    assert view.shares == {"left": 1.0, "right": 1.0, "both": 1.0, "either": 1.0}
    assert view.hidden_by == {}
    assert view.distance == pytest.approx(1.7)
    assert view.incidence_deg == pytest.approx(90.0)


def test_a_shade_half_way_hides_twice_its_width():
    # From y = -0.1 on, seen from y = 0 at half the distance: 0.2 m and all beyond of 0.8 m are hidden.
    view = seen(SHADE.format(width=0.8, y=0.3))
    assert view.shares["left"] == pytest.approx(0.25, abs=0.03)  # columns are a fortieth, and the shade is 2 cm thick
    assert view.hidden_by == {"shade": pytest.approx(1.0 - view.shares["either"])}


def test_two_eyes_see_past_what_hides_a_part_from_each():
    eyes = eye("left", place=(0.0, 0.15, 1.2)), eye("right", place=(0.0, -0.15, 1.2))
    view = seen(SHADE.format(width=0.1, y=0.0), eyes)
    assert view.shares["either"] == 1.0
    assert view.shares["both"] == pytest.approx(view.shares["left"] + view.shares["right"] - 1.0)
    assert view.shares["left"] == pytest.approx(view.shares["right"], abs=0.03)


def test_what_hides_from_each_eye_is_told():
    # A shade before the left eye, and the right one on the far side of the display: nobody sees it.
    eyes = eye("left"), eye("right", place=(4.0, 0.0, 1.2), yaw=math.pi)
    view = seen(SHADE.format(width=1.6, y=0.0), eyes)
    assert view.shares["either"] == 0.0
    assert view.hidden_by == {"shade": 0.5, "facing away": 0.5}


def test_a_display_behind_the_field_or_turned_away_is_not_seen():
    turned = eye("left", yaw=math.pi), eye("right", yaw=math.pi)
    assert seen(eyes=turned).hidden_by == {"outside the field": 1.0}
    behind = eye("left", place=(4.0, 0.0, 1.2), yaw=math.pi), eye("right", place=(4.0, 0.0, 1.2), yaw=math.pi)
    assert seen(eyes=behind).hidden_by == {"facing away": 1.0}


def test_what_is_hidden_is_what_embree_says_at_a_thousand_points():
    embree = pytest.importorskip("embreex.mesh_construction")
    from embreex.rtcore_scene import EmbreeScene

    rng = np.random.default_rng(0)
    boxes = "".join(
        f"  - {{name: b{n}, box: [0.05, {w:.3f}, {h:.3f}], at: [{x:.3f}, {y:.3f}], elevation: {z:.3f},"
        f" heading_deg: {turn:.1f}}}\n"
        for n, (w, h, x, y, z, turn) in enumerate(
            rng.uniform((0.05, 0.05, 0.4, -0.3, 0.9, -40), (0.15, 0.2, 1.4, 0.3, 1.3, 40), (8, 6))
        )
    )
    model, data, display = scene(boxes)
    points = points_on(display, count=1000)
    found = hiders(model, data, eye(), points, display.world_from_target[:3, 0], head=model.body("obstacle/head").id)
    half = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles, owner = [], []
    for geom in np.flatnonzero(model.geom_type == mujoco.mjtGeom.mjGEOM_BOX):
        corners = (half * model.geom_size[geom]) @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom]
        for a, b, c, d in sides:
            triangles += [corners[[a, b, c]], corners[[a, c, d]]]
            owner += [geom, geom]
    other = EmbreeScene()
    embree.TriangleMesh(other, np.array(triangles, dtype=np.float32))
    way = points - eye().place
    length = np.linalg.norm(way, axis=1)
    starts = np.tile(eye().place, (len(points), 1)).astype(np.float32)
    met = other.run(starts, (way / length[:, None]).astype(np.float32), output=True)
    hit = np.where((met["primID"] >= 0) & (met["tfar"] < length - 0.005), np.take(owner, met["primID"]), -1)
    assert len(points) >= 990
    assert 0.2 < np.mean(hit >= 0) < 0.9
    np.testing.assert_array_equal(found, hit)
    assert {name_of(model, geom) for geom in found if geom >= 0} <= {f"b{n}" for n in range(8)}
