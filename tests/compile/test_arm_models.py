"""Arms from files in a scene."""

import shutil
from pathlib import Path

import mujoco
import numpy as np
import pytest

import mjsim
from mjsim.compile import compile_world, export_scene
from mjsim.compile.arm_shapes import solid_keys
from mjsim.compile.geom_groups import DECOR, SEEN
from mjsim.compile.robot_shapes import TOUCHED
from mjsim.world import format_world, parse_world

DATA = Path(__file__).parents[1] / "data" / "arms"
START = "start_deg: [20, -40, 0.1, 0.01, 0.02]"


@pytest.fixture
def folder(tmp_path):
    shutil.copytree(DATA, tmp_path / "arms")
    return tmp_path


def world(folder, more="", base="base: fixed, at: [1, 2], heading_deg: 90"):
    path = folder / "w.yaml"
    arm = f"{{model: arms/gripper.xml, end: grip, at: [0.1, 0, 0.3], rpy_deg: [0, 0, 20], {START}{more}}}"
    path.write_text(f"mjsim: 1\nrobots: [{{name: r, {base}, arms: [{arm}]}}]\n")
    return mjsim.load_world(path)


def test_the_scene_has_the_settled_names_and_the_chain_of_the_file(folder):
    here = world(folder, ", tool: {at: [0, 0, 0.05]}")
    model = compile_world(here).compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    arm = here.robots[0].arms[0].arm
    names = [model.joint(number).name for number in range(model.njnt)]
    assert names == [f"r/arm/joint{number}" for number in (1, 2, 3, 4, 5)]
    assert [model.actuator(number).name for number in range(model.nu)] == names
    # Servos of the file are motors of torque here, with its limits.
    assert not model.actuator_biasprm.any()
    np.testing.assert_allclose(model.actuator_ctrlrange[:, 1], [60, 45, 60, 20, 20])
    world_from_robot = np.array([[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 0], [0, 0, 0, 1.0]])
    rng = np.random.default_rng(3)
    for q in [np.array([*np.radians([20, -40]), 0.1, 0.01, 0.02]), *rng.uniform(-1, 1, (100, 5))]:
        data.qpos[:] = q
        mujoco.mj_kinematics(model, data)
        pose = world_from_robot @ arm.fkine(q)
        np.testing.assert_allclose(data.site("r/arm/tool").xpos, pose[:3, 3], atol=1e-12)
        np.testing.assert_allclose(data.site("r/arm/tool").xmat.reshape(3, 3), pose[:3, :3], atol=1e-12)
        flange = data.site("r/arm/flange")
        np.testing.assert_allclose(flange.xpos + 0.05 * flange.xmat.reshape(3, 3)[:, 2], pose[:3, 3], atol=1e-12)


def test_torques_in_the_scene_are_those_of_the_chain(folder):
    here = world(folder)
    arm = here.robots[0].arms[0].arm
    with mjsim.Simulation(here) as sim:
        model, data = sim.model, mujoco.MjData(sim.model)
        model.dof_damping[:], model.dof_frictionloss[:] = 0.0, 0.0
        model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
        for motion in np.random.default_rng(4).uniform(-1, 1, (30, 3, 5)):
            data.qpos[:], data.qvel[:], data.qacc[:] = motion
            mujoco.mj_inverse(model, data)
            np.testing.assert_allclose(data.qfrc_inverse, arm.rne_nofriction(*motion), atol=1e-11)


def test_looks_and_mass_are_those_of_the_file(folder):
    model = compile_world(world(folder)).compile()
    assert model.body("r/arm/base").mass[0] == pytest.approx(2.0)
    wedge = next(n for n in range(model.ngeom) if model.geom_type[n] == mujoco.mjtGeom.mjGEOM_MESH)
    assert model.body(model.geom_bodyid[wedge]).name == "r/arm/link3"
    np.testing.assert_allclose(model.mat_rgba[model.geom_matid[wedge]], [0.8, 0.1, 0.1, 1.0], atol=1e-6)
    assert model.geom(model.body("r/arm/link4").geomadr[0]).friction[0] == 1.5
    colored = compile_world(world(folder, ", color: '#00ff00'")).compile()
    np.testing.assert_allclose(
        colored.geom_rgba[colored.geom_bodyid == colored.body("r/arm/link2").id][0], [0, 1, 0, 1]
    )


def test_plain_mujoco_loads_the_exported_scene(folder):
    place = export_scene(world(folder, base="preset: pioneer3dx, at: [0, 0]"), folder / "out")
    assert mujoco.MjModel.from_xml_path(str(place)).joint("r/arm/joint5").type[0] == mujoco.mjtJoint.mjJNT_SLIDE


@pytest.mark.slow
def test_the_default_controller_holds_arm_and_fingers_and_goals_move_them(folder):
    with mjsim.Simulation(world(folder)) as sim:
        for _ in range(50):
            sim.step()
        np.testing.assert_allclose(
            sim.motions()["r/arm"].positions, [*np.radians([20, -40]), 0.1, 0.01, 0.02], atol=1e-3
        )
        goal = mjsim.JointGoal(positions=(0.1, -0.5, 0.05, 0.02, 0.005))
        sim.apply("r", mjsim.Command(joints={"arm": goal}))
        for _ in range(75):
            sim.step()
        np.testing.assert_allclose(sim.motions()["r/arm"].positions, goal.positions, atol=2e-3)


def test_a_recording_carries_the_files_of_an_arm(folder):
    with mjsim.Simulation(world(folder)) as sim:
        mjsim.run(sim, seconds=0.2, record=folder / "run.mcap")
    shutil.rmtree(folder / "arms")
    again = mjsim.read_recording(folder / "run.mcap")
    assert again.joints["r/arm"].positions.shape == (5, 5)
    assert again.world.robots[0].arms[0].arm.n == 5


def test_a_written_world_reads_back_equal(folder):
    here = world(folder, ", tool: {at: [0, 0, 0.05]}")
    assert parse_world(format_world(here), source=here.source) == here


@pytest.mark.parametrize(
    ("sentence", "arm"),
    [
        ("an arm has joints; give dh: {rows: [...]}, a preset, or model: FILE", "{name: a}"),
        (
            "an arm has a table of joints or a model, not both; leave one out",
            "{preset: puma560, model: arms/lamp.urdf}",
        ),
        ("end names a part of a model; an arm of a table ends at its last row", "{preset: puma560, end: x}"),
        ("start_deg holds 2 values; the arm has 3 joints", "{model: arms/lamp.urdf, end: tip, start_deg: [1, 2]}"),
        ("'arm.txt' is not a model; name an MJCF (.xml), URDF (.urdf), xacro or SDF (.sdf) file", "{model: arm.txt}"),
    ],
)
def test_invalid_keys_are_errors(sentence, arm, folder):
    path = folder / "w.yaml"
    path.write_text(f"mjsim: 1\nrobots:\n- {{name: r, base: fixed, at: [0, 0], arms: [{arm}]}}\n")
    with pytest.raises(mjsim.WorldError) as caught:
        mjsim.load_world(path)
    assert str(caught.value).endswith(sentence)
    assert str(caught.value).startswith(f"{path}:3:")


def test_geoms_of_a_file_are_seen_touched_or_both_and_keep_their_contacts():
    xml = """<mujoco><worldbody><body><geom name="one" size="0.1" condim="4" friction="0.7 0.1 0.2" priority="3"
      solref="0.03 0.8" solimp="0.8 0.9 0.01 0.4 3"/></body></worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(xml)
    groups = {
        (seen, touched): solid_keys(model, 0, seen=seen, touched=touched) for seen in (0, 1) for touched in (0, 1)
    }
    for (_, touched), keys in groups.items():
        if not touched:
            assert (keys["contype"], keys["conaffinity"]) == (0, 0)
            continue
        assert (keys["condim"], keys["priority"]) == (4, 3)
        np.testing.assert_array_equal(keys["friction"], [0.7, 0.1, 0.2])
        np.testing.assert_array_equal(keys["solref"], [0.03, 0.8])
        np.testing.assert_array_equal(keys["solimp"], [0.8, 0.9, 0.01, 0.4, 3.0])
    assert groups[1, 1]["group"] == SEEN
    assert groups[0, 1]["group"] == TOUCHED
    assert groups[1, 0]["group"] == DECOR
