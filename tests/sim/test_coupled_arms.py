"""The default controller holds arms whose joints are strongly coupled, and slides pass through the link before them."""

import numpy as np
import pytest

import mjsim
from mjsim.algorithms.estimation.parameter_learning import largest_inertia, steady_inertia
from mjsim.world import parse_world

SCARA = (
    "dh: {unit: mm, rows: [{a: 325, d: 400, range_deg: [-170, 170]}, {a: 275, alpha_deg: 180, range_deg: [-145, 145]},"
    " {slide: true, range: [0, 200]}, {range_deg: [-360, 360]}]}"
)
ROW = "at: [0, 0, 2], dh: {rows: [{a: 0.3}, {a: 0.3}, {a: 0.3}, {a: 0.3}]}"
RATE, FREQUENCY = 250.0, 25.0
"""Of the default controller [Hz, rad/s]."""


def standing(arm: str, more: str = "") -> mjsim.World:
    return parse_world(f"mjsim: 1\nrobots: [{{name: r, base: fixed, at: [0, 0], arms: [{{{arm}}}]}}]\n{more}")


def growth(model, inertia, q) -> float:
    """Return the ratio by which the fastest motion of a held arm grows in a period of the controller."""
    step, by = 1.0 / RATE, np.linalg.solve(model.inertia(q), np.diag(inertia))
    same = np.eye(len(q))
    speed = np.hstack([same - 2.0 * FREQUENCY * step * by, -(FREQUENCY**2) * step * by])
    place = np.hstack([step * speed[:, : len(q)], same + step * speed[:, len(q) :]])
    return float(np.abs(np.linalg.eigvals(np.vstack([speed, place]))).max())


@pytest.mark.parametrize(("arm", "eased"), [("preset: puma560", False), (SCARA, True), (ROW, True)])
def test_gains_of_strongly_coupled_joints_are_as_small_as_stability_needs(arm, eased):
    with mjsim.Simulation(standing(arm)) as sim:
        info = sim.robots["r"].arms["arm"]
    full = largest_inertia(info.model, info)
    used = steady_inertia(info.model, info, FREQUENCY / RATE)
    rng = np.random.default_rng(7)
    places = rng.uniform(np.maximum(info.lower, -3.0), np.minimum(info.upper, 3.0), (60, len(full)))
    assert max(growth(info.model, used, q) for q in places) < 1.0
    assert (max(growth(info.model, full, q) for q in places) > 1.0) == eased
    assert (used < full).any() == eased


@pytest.mark.slow
def test_a_scara_reaches_its_goal_with_its_default_controller_and_lifts_through_its_own_link():
    goals = "navigator: {use: 'mjsim.algorithms.joint_path:JointPath', to_deg: [45, 30, 0.1, 90], seconds: 0.6}"
    with mjsim.Simulation(standing(SCARA, f"run: {{seconds: 0.8, drivers: {{r: {{{goals}}}}}}}\n")) as sim:
        motion = mjsim.run(sim).joints["r/arm"]
    wanted = [np.radians(45.0), np.radians(30.0), 0.1, np.radians(90.0)]
    np.testing.assert_allclose(motion.positions[-1], wanted, atol=0.02)
    assert np.abs(motion.positions - motion.goal)[:, 2].max() < 0.01
