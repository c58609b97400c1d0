"""Tables of arms: keys, units, what is derived, and what is refused."""

import mujoco
import numpy as np
import pytest

from mjsim.mechanics import Arm, capsule, nearest_valid
from mjsim.mechanics.link_inertias import Solid, tensor


def test_degrees_and_millimetres_mean_the_same_as_radians_and_metres():
    one = Arm.from_dh([{"alpha_deg": 90, "a": 150, "d": 20, "theta_deg": 10, "range_deg": [-170, 170]}], unit="mm")
    other = Arm.from_dh(
        [{"alpha": np.pi / 2, "a": 0.15, "d": 0.02, "theta": np.radians(10), "range": np.radians([-170, 170])}]
    )
    np.testing.assert_allclose(one.fkine([0.3]), other.fkine([0.3]), atol=1e-15)
    np.testing.assert_allclose(one.limits, other.limits)


def test_four_numbers_are_theta_d_a_and_alpha():
    four = Arm.from_dh([[0.1, 0.2, 0.3, 0.4]], "modified")
    keys = Arm.from_dh([{"theta": 0.1, "d": 0.2, "a": 0.3, "alpha": 0.4}], "modified")
    np.testing.assert_array_equal(four.fkine([0.5]), keys.fkine([0.5]))


def test_limits_of_a_slide_are_in_the_unit_of_the_table():
    arm = Arm.from_dh([{"slide": True, "range": [0, 800], "center": [0, 0, 10], "mass": 1}], unit="mm")
    assert arm.limits == (0.0, 0.8)
    assert arm.links[0].center == (0.0, 0.0, 0.01)


def test_a_link_without_mass_weighs_as_much_as_a_capsule_in_mujoco():
    start, end, radius = np.array([0.1, 0.0, 0.05]), np.array([0.3, -0.2, 0.4]), 0.06
    ours = capsule(start, end, radius)
    spec = mujoco.MjSpec()
    body = spec.worldbody.add_body()
    body.add_geom(type=mujoco.mjtGeom.mjGEOM_CAPSULE, fromto=[*start, *end], size=[radius, 0, 0], density=1000.0)
    model = spec.compile()
    assert ours.mass == pytest.approx(model.body_mass[1], rel=1e-9)
    np.testing.assert_allclose(ours.center, model.body_ipos[1], atol=1e-9)
    rotation = np.zeros(9)
    mujoco.mju_quat2Mat(rotation, model.body_iquat[1])
    rotation = rotation.reshape(3, 3)
    np.testing.assert_allclose(
        tensor(ours.inertia), rotation @ np.diag(model.body_inertia[1]) @ rotation.T, rtol=1e-6, atol=1e-9
    )


def test_the_arm_of_a_table_has_the_masses_of_its_capsules():
    arm = Arm.from_dh([{"a": 0.5, "radius": 0.05}, {"a": 0.25, "radius": 0.05}])
    masses = [link.mass for link in arm.links]
    ball = 4 / 3 * np.pi * 0.05**3 * 1000
    # The bone of the first reaches to the second joint, that of the last to the flange.
    assert masses == pytest.approx([np.pi * 0.05**2 * 0.5 * 1000 + ball, np.pi * 0.05**2 * 0.25 * 1000 + ball])


@pytest.mark.parametrize(
    "inertia", [(0.0, 0.35, 0.0, 0.0, 0.0, 0.0), (0.1, 0.1, 0.5, 0.02, 0.0, 0.01), (1.0, 1.0, 1.0, 0, 0, 0)]
)
def test_the_nearest_valid_inertia_is_one_that_mujoco_takes(inertia):
    near = nearest_valid(Solid(0.0, (0.0, 0.0, 0.0), inertia))
    xx, yy, zz, xy, yz, xz = near.inertia
    inertial = f'<inertial pos="0 0 0" mass="{near.mass}" fullinertia="{xx} {yy} {zz} {xy} {xz} {yz}"/>'
    xml = f"<mujoco><worldbody><body><joint/>{inertial}</body></worldbody></mujoco>"
    model = mujoco.MjModel.from_xml_string(xml)
    wanted = np.sort(np.linalg.eigvalsh(tensor(near.inertia)))
    np.testing.assert_allclose(np.sort(model.body_inertia[1]), wanted, rtol=1e-9)
    if inertia[0] == 1.0:
        assert near.inertia == pytest.approx(inertia)


BAD = {
    "row 1: unknown key 'aplha_deg'; did you mean 'alpha_deg'?": [{"aplha_deg": 90}],
    "row 1: both 'alpha' and 'alpha_deg' are given; give one": [{"alpha": 1, "alpha_deg": 90}],
    "row 2: a is nan; it must be finite": [{}, {"a": float("nan")}],
    "row 1: the row holds 3 numbers; it must hold 4": [[0, 0, 0]],
    "row 1: mass is -1; it must not be below 0": [{"mass": -1}],
    "row 1: center is given without mass; give mass too, or neither": [{"center": [0, 0, 0]}],
    "row 1: inertia holds 3 numbers; it must hold 6": [{"mass": 1, "inertia": [1, 1, 1]}],
    "row 1: the smallest principal moment of the inertia is -1 kg m^2; it must not be below 0": [
        {"mass": 1, "inertia": [1, 1, -1, 0, 0, 0]}
    ],
    "row 1: gear is 0; it must not be 0": [{"gear": 0}],
    "row 1: coulomb is [-1, 1]; the first must be 0 or more, the second 0 or less": [
        {"friction": {"coulomb": [-1, 1]}}
    ],
    "row 1: range is [3, -3]; the first must be below the second": [{"range": [3, -3]}],
    "row 1: range_deg is in degrees; this joint slides: give range, in the unit of the table": [
        {"slide": True, "range_deg": [0, 1]}
    ],
    "row 1: max_torque is 0; it must be above 0": [{"torque": 0}],
    "the arm has no links; give at least one row": [],
}


@pytest.mark.parametrize(("sentence", "rows"), BAD.items())
def test_a_bad_table_is_refused_in_one_sentence(sentence, rows):
    with pytest.raises(ValueError, match=r"\A.*\Z") as caught:
        Arm.from_dh(rows)
    assert str(caught.value) == sentence


def test_a_misspelt_convention_or_unit_is_named():
    with pytest.raises(ValueError, match=r"^convention is 'standart'; did you mean 'standard'[?]$"):
        Arm.from_dh([{}], "standart")
    with pytest.raises(ValueError, match=r"^unit is 'cm'; "):
        Arm.from_dh([{}], unit="cm")
