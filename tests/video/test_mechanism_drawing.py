"""Mechanisms on sheets and in films: bodies to scale, joints with their symbols, views that hold the whole motion."""

import math

import mujoco
import numpy as np
import pytest

import mjsim
from mjsim.compile import compile_world, overview_of
from mjsim.plan import blend, parse_color
from mjsim.sim import Onlooker
from mjsim.video import draw_world
from mjsim.video.diagram_drawing import body_outlines, distances, posed
from mjsim.video.diagrams import DiagramFrame, best_look
from mjsim.video.ink import ESTIMATE, INK, PAPER
from mjsim.video.joint_symbols import SYMBOLS, draw_joint
from mjsim.video.paper import blank
from mjsim.video.plan_view import PlanView
from mjsim.world.items.mechanisms.joint_kinds import JOINTS

ARM = """
mjsim: 1
mechanisms:
  - name: arm
    at: [1, 2]
    heading_deg: 90
    elevation: 3
    bodies: [{name: bar, rod: [2.0, 0.1], color: "#b06a4a"}]
    joints: [{revolute: q, of: [ground, bar], axis: %s}]
    actuators: [{angle: q, signal: {ramp: {slope_deg: 90}}}]
"""


def test_each_kind_of_joint_has_a_symbol_of_its_own():
    assert SYMBOLS.keys() == JOINTS.keys()
    for along in (True, False):
        sheets = []
        for kind in JOINTS:
            drawing = blank(PlanView.around(0.0, 0.0, 100.0, 80, 80))
            draw_joint(drawing, kind, mjsim.Pose(0.0, 0.0, 0.3), along=along)
            sheets.append(drawing.image)
        assert all((sheet == INK).all(axis=-1).sum() > 20 for sheet in sheets)
        same = [(a, b) for a in range(len(sheets)) for b in range(a) if (sheets[a] == sheets[b]).all()]
        assert not same


def test_a_body_is_as_long_and_as_thick_in_the_drawing_as_it_is():
    mechanism = mjsim.parse_world(ARM % "[0, 1, 0]").mechanisms[0]
    ((name, outline),) = body_outlines(posed(mechanism, np.array([0.0])))
    assert name == "bar"
    # A capsule of 2 m that points to +y from [1, 2].
    np.testing.assert_allclose([outline.min(axis=0), outline.max(axis=0)], [[0.9, 1.9], [1.1, 4.1]], atol=1e-3)


@pytest.mark.parametrize(("axis", "toward"), [("[0, 1, 0]", [-1, 0, 0]), ("[0, 0, 1]", [0, 0, 1])])
def test_a_diagram_looks_along_the_axes_of_a_mechanism_in_a_plane(axis, toward):
    look = best_look(mjsim.parse_world(ARM % axis).mechanisms[0])[:, :3]
    # Turned by 90 degrees, y of the mechanism is -x of the world.
    assert abs(look[2] @ toward) == pytest.approx(1.0)
    np.testing.assert_allclose(look @ look.T, np.eye(3), atol=1e-12)


@pytest.mark.slow
def test_the_sheet_shows_a_mechanism_and_what_moves_it():
    page = draw_world(mjsim.parse_world(ARM % "[0, 1, 0]"))
    body = blend(parse_color("#b06a4a"), PAPER, 0.6)
    assert (page == body).all(axis=-1).sum() > 1000
    assert (page == ESTIMATE).all(axis=-1).sum() > 20
    assert page[1].min() == 255  # nothing runs into the edge


@pytest.mark.slow
def test_diagrams_move_with_the_joints_and_hold_the_whole_motion():
    world = mjsim.parse_world(ARM % "[0, 1, 0]")
    motion = np.linspace(0.0, 2.0 * math.pi, 60)[:, None]
    frame = DiagramFrame(world, {"arm": motion})
    color = blend(parse_color("#b06a4a"), PAPER, 0.6)
    seen = []
    for values in motion[[0, 15, 30, 45]]:
        rows, columns = np.nonzero((frame.draw(0.0, {"arm": values}) == color).all(axis=-1))
        seen.append((rows.mean(), columns.mean()))
        assert rows.min() > 5
        assert rows.max() < 714
    # Level, down, level the other way, and up: a positive angle about y turns downwards.
    assert seen[1][0] > seen[0][0] + 50 > seen[3][0] + 100
    assert abs(seen[0][0] - seen[2][0]) < 10


def test_the_overview_of_a_film_sees_where_a_mechanism_goes():
    world = mjsim.parse_world(ARM % "[0, 1, 0]")
    mechanism = world.mechanisms[0]
    boxes = [mechanism.spanned(np.array([angle])) for angle in np.linspace(0.0, 2.0 * np.pi, 30)]
    reach = np.array([np.min(boxes, axis=(0, 1)), np.max(boxes, axis=(0, 1))])
    model = compile_world(world).compile()
    model.camera("overview").pos = overview_of(world, reach)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    place, turn = data.camera("overview").xpos, data.camera("overview").xmat.reshape(3, 3)
    corners = np.array([[x, y, z] for x in reach[:, 0] for y in reach[:, 1] for z in reach[:, 2]])
    right, up, back = ((corners - place) @ turn).T
    rise = math.tan(math.radians(float(model.camera("overview").fovy[0]) / 2))
    assert np.all(np.abs(up / -back) < rise)
    assert np.all(np.abs(right / -back) < rise * 16 / 9)


def test_a_distance_that_follows_a_motion_is_drawn_between_its_points():
    text = (ARM % "[0, 1, 0]").replace("angle: q", "distance: [{ground: [0, 0, -2]}, bar.end], name: ram")
    mechanism = mjsim.parse_world(text.replace("slope_deg: 90", "from: 2.5, slope: 0.1")).mechanisms[0]
    (ends,) = distances(posed(mechanism, mechanism.assembly.start, best_look(mechanism)), led=True)
    assert np.hypot(*(ends[1] - ends[0])) == pytest.approx(2.5)


def test_the_overview_of_a_run_follows_a_mechanism_that_leaves_the_place_of_its_start():
    world = mjsim.parse_world(
        "mjsim: 1\nmechanisms:\n"
        "  - {name: m, elevation: 1, bodies: [{name: s, box: [1, 1, 1], color: '#ff0000'}],"
        " joints: [{prismatic: x, of: [ground, s], axis: [1, 0, 0]}]}\n"
    )
    with Onlooker(world) as onlooker:
        for way in (0.0, 20.0):
            onlooker.show(np.array([way]), None)
            seen = onlooker.outside("overview", width=64, height=36).astype(int)
            assert (seen[..., 0] > 2 * seen[..., 1] + 20).any()
