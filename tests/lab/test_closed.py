"""Under a controller that is designed for the linear plant the nonlinear one does what it does, while it stays near."""

from functools import partial

import numpy as np
import pytest

import mjsim
from mjsim.lab import ScenePlant, experiment, lead_design, placed_design
from mjsim.lab.closed import closed_loop
from mjsim.lab.plant_page import figures_of, page_files

POLE = """
mjsim: 1
mechanisms:
  - name: m
    elevation: 2
    bodies: [{name: pole, mass: 0.2, rod: [1.0, 0.03]}]
    joints: [{revolute: q, of: [ground, pole], axis: [0, 1, 0], start_deg: -90}]
run: {step_ms: 1}
plants: [{name: p, of: m, input: q, outputs: [q], amplitude: HEIGHT}]
"""


def pole(height: float) -> ScenePlant:
    """A pole that stands on its pivot, moved by the torque there [N m]."""
    world = mjsim.parse_world(POLE.replace("HEIGHT", str(height)))
    return ScenePlant(world, world.plants[0])


@pytest.mark.slow
@pytest.mark.parametrize(
    "designer", [partial(placed_design, poles=[-6.0, -8.0]), partial(lead_design, margin_deg=50.0, crossover=8.0)]
)
def test_a_pole_near_upright_moves_as_its_linear_loop(designer):
    scene = pole(1e-3)
    found = closed_loop(scene, designer(scene.linear))
    assert found.fit[0] > 99.0
    assert found.rough is None


def test_a_pole_pushed_too_far_ends_where_the_torques_of_the_real_pole_balance():
    scene = pole(3.0)
    design = placed_design(scene.linear, [-6.0, -8.0])
    found = closed_loop(scene, design)
    # Of u = r - K q the real pole ends where u + m g l / 2 sin(q) = 0, the linear one where u + m g l / 2 q = 0.
    lean = found.step[0, -1]
    gravity = 0.2 * 9.81 * 0.5
    left = [3.0 - design.gain[0] * q + gravity * pull for q, pull in ((lean, np.sin(lean)), (lean, lean))]
    assert abs(left[0]) < 0.3 * abs(left[1])
    assert found.fit[0] < 99.0


def test_a_plant_that_runs_away_is_followed_until_then():
    scene = pole(1.0)
    found = scene.controlled(lambda states, outputs: 1e8, 2000)
    assert 1 < found.shape[1] < 2000
    assert np.isfinite(found).all()


def test_poles_too_fast_for_the_steps_of_mujoco_are_said_to_run_away():
    scene = pole(1e-3)
    found = closed_loop(scene, placed_design(scene.linear, [-3000.0, -4000.0]))
    assert found.fit is None
    assert np.isfinite(found.step).all()


@pytest.mark.slow
def test_the_page_shows_the_nonlinear_loop_and_says_how_well_the_linear_one_fits():
    world = mjsim.parse_world(POLE.replace("HEIGHT", "0.001"))
    found = experiment(world, world.plants[0], designers=[partial(placed_design, poles=[-6.0, -8.0])])
    assert figures_of(found)["designs"][0]["nonlinear_fit_percent"][0] > 99.0
    assert "linear loop fits the nonlinear one" in page_files(found)["p.html"].decode()
