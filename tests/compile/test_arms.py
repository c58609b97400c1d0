"""Compiled arms: frames, Jacobians and torques of MuJoCo against tables, and what is written for plain MuJoCo."""

import mujoco
import numpy as np
import pytest

from mjsim.compile import compile_world, export_scene, refused_links, set_exact_masses
from mjsim.world import parse_world
from tests.mechanics.arms import MODIFIED_ROWS, SLIDE_ROWS, golden, plain_frames

ROUNDING = 1e-12
"""[m, rad]"""


def flow(row):
    return "{" + ", ".join(f"{key}: {str(value).lower()}" for key, value in row.items()) + "}"


def table(rows, convention):
    return f"dh: {{convention: {convention}, rows: [{', '.join(map(flow, rows))}]}}"


ARMS = {
    "UP6": "preset: motoman_up6",
    "Puma 560": "preset: puma560",
    "with a slide": table(SLIDE_ROWS, "standard"),
    "modified": table(MODIFIED_ROWS, "modified"),
}


class Compiled:
    """One arm on a fixed base at the origin, in MuJoCo."""

    def __init__(self, name, more=""):
        self.world = parse_world(
            f"mjsim: 1\nrobots: [{{name: r, base: fixed, at: [0, 0], arms: [{{{ARMS[name]}{more}}}]}}]"
        )
        self.arm = self.world.robots[0].arms[0].arm
        self.model = compile_world(self.world).compile()
        set_exact_masses(self.model, self.world)
        self.data = mujoco.MjData(self.model)
        names = [f"r/arm/joint{number}" for number in range(1, self.arm.n + 1)]
        self.q = np.array([self.model.joint(name).qposadr[0] for name in names])
        self.v = np.array([self.model.joint(name).dofadr[0] for name in names])

    def put(self, q):
        self.data.qpos[self.q] = q
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)

    def pose(self, site):
        pose, found = np.eye(4), self.data.site(f"r/arm/{site}")
        pose[:3, :3], pose[:3, 3] = found.xmat.reshape(3, 3), found.xpos
        return pose

    def jacobian(self):
        linear, angular = np.zeros((2, 3, self.model.nv))
        mujoco.mj_jacSite(self.model, self.data, linear, angular, self.model.site("r/arm/tool").id)
        return np.vstack([linear[:, self.v], angular[:, self.v]])

    def torques(self, q, qd, qdd):
        """Return the torques of the rigid links and rotors, without friction and limits, as MuJoCo has them."""
        self.model.dof_damping[:], self.model.dof_frictionloss[:] = 0.0, 0.0
        self.model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
        self.data.qpos[self.q], self.data.qvel[self.v], self.data.qacc[self.v] = q, qd, qdd
        mujoco.mj_inverse(self.model, self.data)
        return self.data.qfrc_inverse[self.v].copy()


@pytest.mark.parametrize(("name", "file", "scale"), [("UP6", "up6", 1000.0), ("Puma 560", "puma560", 1.0)])
def test_flange_and_jacobian_are_those_of_another_toolbox(name, file, scale):
    compiled, known = Compiled(name), golden(file)
    for q, pose, jacobian in zip(known["q"], known["fkine"], known["jacob0"], strict=True):
        compiled.put(q)
        pose[:3, 3] /= scale
        jacobian[:3] /= scale
        np.testing.assert_allclose(compiled.pose("flange"), pose, atol=ROUNDING)
        np.testing.assert_allclose(compiled.jacobian(), jacobian, atol=ROUNDING)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=[] if n in ("Puma 560", "with a slide") else [pytest.mark.slow]) for n in ARMS]
)
def test_links_are_where_the_plain_product_of_matrices_has_them(name):
    compiled = Compiled(name, ", start_deg: [10, 0.2, 30]" if name == "with a slide" else "")
    for q in np.random.default_rng(1).uniform(-np.pi, np.pi, (1000, compiled.arm.n)):
        compiled.put(q)
        plain = plain_frames(name, q)
        places = [compiled.data.body(f"r/arm/link{number}").xpos for number in range(1, len(plain) + 1)]
        np.testing.assert_allclose(places, plain[:, :3, 3], atol=ROUNDING)
        np.testing.assert_allclose(compiled.pose("tool"), plain[-1], atol=ROUNDING)


def test_torques_of_the_compiled_puma_are_those_of_another_toolbox():
    compiled, known = Compiled("Puma 560"), golden("puma560")
    for motion in zip(known["q"], known["qd"], known["qdd"], known["rne_nofriction"], strict=True):
        np.testing.assert_allclose(compiled.torques(*motion[:3]), motion[3], atol=1e-11)


@pytest.mark.parametrize("name", ARMS)
def test_torques_of_a_compiled_arm_are_those_of_its_table(name):
    compiled = Compiled(name)
    motion = np.random.default_rng(2).uniform(-1.0, 1.0, (3, 30, compiled.arm.n))
    found = [compiled.torques(*each) for each in np.moveaxis(motion, 1, 0)]
    np.testing.assert_allclose(found, compiled.arm.rne_nofriction(*motion), rtol=1e-11, atol=1e-10)


def test_an_arm_starts_where_the_world_says_on_a_turned_base_with_its_tool():
    world = parse_world(
        "mjsim: 1\nrobots: [{name: r, base: fixed, at: [2, 1], heading_deg: 90, arms: [{preset: puma560,"
        " at: [0.1, 0, 0.3], rpy_deg: [0, 0, 30], tool: {at: [0, 0, 0.1], rpy_deg: [10, 20, 30]}, "
        "start_deg: [10, 20, -30, 40, 50, 60]}]}]"
    )
    model = compile_world(world).compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    world_from_robot = np.array([[0, -1, 0, 2], [1, 0, 0, 1], [0, 0, 1, 0], [0, 0, 0, 1.0]])
    pose = world_from_robot @ world.robots[0].arms[0].arm.fkine(np.radians([10, 20, -30, 40, 50, 60]))
    np.testing.assert_allclose(data.site("r/arm/tool").xpos, pose[:3, 3], atol=ROUNDING)
    np.testing.assert_allclose(data.site("r/arm/tool").xmat.reshape(3, 3), pose[:3, :3], atol=ROUNDING)
    np.testing.assert_allclose(np.degrees(data.qpos), [10, 20, -30, 40, 50, 60], atol=1e-10)


def test_motors_have_gears_limits_and_friction_of_the_table():
    model = Compiled("Puma 560").model
    motor, dof = model.actuator("r/arm/joint1"), model.joint("r/arm/joint1").dofadr[0]
    assert motor.gear[0] == -62.6111
    assert motor.ctrlrange[1] * 62.6111 == pytest.approx(97.6)
    assert model.dof_armature[dof] == pytest.approx(200e-6 * 62.6111**2)
    assert model.dof_damping[dof] == pytest.approx(1.48e-3 * 62.6111**2)
    assert model.dof_frictionloss[dof] == pytest.approx(62.6111 * (0.395 + 0.435) / 2)
    np.testing.assert_allclose(np.degrees(model.joint("r/arm/joint2").range), [-45, 225])


def test_plain_mujoco_loads_a_link_that_it_would_refuse(tmp_path):
    world = Compiled("Puma 560").world
    assert refused_links(world) == ("r/arm/link1", "r/arm/link3")
    model = mujoco.MjModel.from_xml_path(str(export_scene(world, tmp_path)))
    # The nearest of (0, 0.35, 0) whose moments keep the triangle inequality: a third of the excess taken from each.
    moments = np.sort(model.body("r/arm/link1").inertia)
    np.testing.assert_allclose(moments, [0.35 / 3, 0.35 / 3, 0.7 / 3], rtol=1e-6)
    assert model.body("r/arm/link2").mass[0] == 17.4


def test_an_arm_that_nobody_holds_falls_with_the_acceleration_of_its_table():
    compiled = Compiled("with a slide")
    model, data = compiled.model, compiled.data
    q = np.array([0.3, 0.2, -0.4])
    data.qpos[compiled.q] = q
    mujoco.mj_forward(model, data)
    fall = -np.linalg.solve(compiled.arm.inertia(q), compiled.arm.gravload(q))
    np.testing.assert_allclose(data.qacc[compiled.v], fall, rtol=1e-9)


def test_links_of_an_arm_do_not_begin_in_contact_but_meet_a_box():
    text = (
        "mjsim: 1\nobstacles: [{{box: [0.3, 2, 1.5], at: [{x}, 0]}}]\n"
        "robots: [{{name: r, base: fixed, at: [0, 0], arms: [{{preset: puma560, start_deg: [0, 20, -110, 0, 0, 0]}}]}}]"
    )
    for x, touches in ((3.0, False), (0.8, True)):
        model = compile_world(parse_world(text.format(x=x))).compile()
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        assert (data.ncon > 0) == touches


def test_an_arm_that_begins_below_the_floor_passes_through_it():
    compiled = Compiled("UP6")
    mujoco.mj_forward(compiled.model, compiled.data)
    assert compiled.data.body("r/arm/link6").xpos[2] == pytest.approx(-0.735)
    assert compiled.data.ncon == 0
