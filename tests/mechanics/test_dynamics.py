"""Torques, masses and friction against another toolbox and against energy."""

import numpy as np
import pytest

from mjsim.mechanics import Arm
from tests.mechanics.arms import PUMA_ROWS, TABLES, arm_of, golden, plain_frames

ROUNDING = 1e-12
"""Of sums of a hundred products, as a share of the largest torque."""


@pytest.fixture(scope="module")
def known():
    return golden("puma560")


def test_torques_of_the_puma_are_those_of_another_toolbox(known):
    arm, motion = arm_of("Puma 560"), (known["q"], known["qd"], known["qdd"])
    np.testing.assert_allclose(arm.rne(*motion), known["rne"], rtol=ROUNDING, atol=1e-11)
    np.testing.assert_allclose(arm.rne_nofriction(*motion), known["rne_nofriction"], rtol=ROUNDING, atol=1e-11)
    np.testing.assert_allclose(arm.gravload(known["q"]), known["gravload"], atol=1e-12)
    np.testing.assert_allclose(arm.inertia(known["q"]), known["inertia"], atol=1e-12)


@pytest.mark.parametrize("name", TABLES)
def test_gravity_is_the_slope_of_potential_energy(name):
    arm, step = arm_of(name), 1e-6
    q = np.random.default_rng(1).uniform(-1.0, 1.0, arm.n)
    centers = np.array([[*link.center, 1.0] for link in arm.links])
    masses = np.array([link.mass for link in arm.links])

    def height(values):
        return 9.81 * masses @ (plain_frames(name, values) @ centers[:, :, None])[:, 2, 0]

    slope = [(height(q + offset) - height(q - offset)) / (2 * step) for offset in np.eye(arm.n) * step]
    np.testing.assert_allclose(arm.gravload(q), slope, rtol=1e-7, atol=1e-7)


@pytest.mark.parametrize("name", TABLES)
def test_power_of_the_torques_is_the_rate_of_energy(name):
    arm, step = arm_of(name), 1e-5
    rng = np.random.default_rng(2)
    q, qd, qdd = rng.uniform(-1.0, 1.0, (3, 30, arm.n))

    def kinetic(time):
        rates = qd + qdd * time
        return 0.5 * np.einsum("ki,kij,kj->k", rates, arm.inertia(q + qd * time + 0.5 * qdd * time**2), rates)

    power = (arm.rne_nofriction(q, qd, qdd) * qd).sum(axis=-1)
    gained = (kinetic(step) - kinetic(-step)) / (2 * step) + (arm.gravload(q) * qd).sum(axis=-1)
    np.testing.assert_allclose(power, gained, rtol=1e-7, atol=1e-6)


@pytest.mark.parametrize("name", TABLES)
def test_torques_are_masses_coriolis_gravity_and_friction_together(name):
    arm = arm_of(name)
    q, qd, qdd = np.random.default_rng(3).uniform(-2.0, 2.0, (3, 30, arm.n))
    both = (arm.inertia(q) @ qdd[..., None] + arm.coriolis(q, qd) @ qd[..., None])[..., 0]
    whole = both + arm.gravload(q) + arm.friction(qd)
    np.testing.assert_allclose(arm.rne(q, qd, qdd), whole, rtol=1e-11, atol=1e-10)


@pytest.mark.parametrize("name", TABLES)
def test_the_rate_of_masses_less_twice_coriolis_is_skew_symmetric(name):
    arm, step = arm_of(name), 1e-6
    q, qd = np.random.default_rng(4).uniform(-1.0, 1.0, (2, 20, arm.n))
    rate = (arm.inertia(q + step * qd) - arm.inertia(q - step * qd)) / (2 * step)
    skew = rate - 2.0 * arm.coriolis(q, qd)
    np.testing.assert_allclose(skew, -np.swapaxes(skew, -1, -2), atol=2e-7)


@pytest.mark.parametrize("name", TABLES)
def test_torques_are_linear_in_the_parameters_of_links(name):
    arm = arm_of(name)
    q, qd, reference, qdd = np.random.default_rng(5).uniform(-2.0, 2.0, (4, 20, arm.n))
    found = arm.regressor(q, qd, reference, qdd) @ arm.parameters()
    rigid = arm.inertia(q) - np.diag(arm.armature())
    wanted = (rigid @ qdd[..., None] + arm.coriolis(q, qd) @ reference[..., None])[..., 0] + arm.gravload(q)
    np.testing.assert_allclose(found, wanted, rtol=1e-10, atol=1e-9)


def test_dry_friction_differs_both_ways_and_is_nothing_at_rest():
    arm = Arm.from_dh(PUMA_ROWS)
    gear, viscous, plus, minus = 62.6111, 0.00148, 0.395, -0.435
    rate = 0.7
    assert arm.friction([rate] * 6)[0] == pytest.approx(gear * plus + gear**2 * viscous * rate)
    assert arm.friction([-rate] * 6)[0] == pytest.approx(gear * minus - gear**2 * viscous * rate)
    assert not arm.friction(np.zeros(6)).any()


def test_an_arm_upside_down_feels_gravity_the_other_way():
    upright = Arm.from_dh(PUMA_ROWS)
    hung = upright.moved(np.diag([1.0, -1.0, -1.0, 1.0]))
    q = np.random.default_rng(6).uniform(-2.0, 2.0, (5, 6))
    np.testing.assert_allclose(hung.gravload(q), -upright.gravload(q), atol=1e-12)
