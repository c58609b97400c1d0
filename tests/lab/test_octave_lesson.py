"""The step of the lesson in Octave: its feedback is the one that the laboratory designs from the scene."""

import shutil

import control
import numpy as np
import pytest

import mjsim
from mjsim.lab import ScenePlant, placed_design
from mjsim.modules import check_modules, load_runnable

needs_octave = pytest.mark.skipif(
    not (shutil.which("octave-cli") or shutil.which("octave")),
    reason="no Octave here; type: sudo apt-get install --no-install-recommends octave",
)


def test_the_step_in_octave_finds_its_module():
    assert check_modules(load_runnable("lab-6-octave")) == []


@needs_octave
@pytest.mark.slow
def test_the_step_in_octave_moves_the_cart_as_poles_placed_by_the_laboratory_do():
    world = load_runnable("lab-6-octave")
    use = world.mechanisms[0].actuators[0].controller
    linear = ScenePlant(world, world.plants[0]).linear
    K = np.array([placed_design(linear, use.arguments()["poles"]).gain])
    closed = control.ss(linear.A - linear.B @ K, np.zeros((4, 1)), np.eye(4), np.zeros((4, 1)))
    with mjsim.Simulation(world) as sim:
        rows = []
        for _ in range(25):
            rows.append([sim.time, *sim.motions()["cart"].positions])
            sim.step()
    times, way, angle = np.array(rows).T
    start = [-0.3, np.radians(5.0), 0.0, 0.0]  # from a goal of 0.3 m, upright
    expected = control.initial_response(closed, times, start).outputs
    np.testing.assert_allclose(way - 0.3, expected[0], atol=2e-3)
    np.testing.assert_allclose(angle + np.pi / 2, expected[1], atol=2e-3)
