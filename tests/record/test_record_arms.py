"""Recordings and reports of arms: what is written is what moved, exactly, and what is drawn of it."""

import csv
import json
from itertools import islice

import numpy as np
import pytest
from scipy.io import loadmat

import mjsim
from mjsim.errors import RecordingError
from mjsim.geometry import Pose3
from mjsim.mechanics import JointMotion
from mjsim.record import export_csv, export_mat, export_npz
from mjsim.record.joint_messages import KEYS, joint_messages
from mjsim.report import write_report
from mjsim.report.arm_plots import drive_plots
from mjsim.run import drivers_of
from mjsim.world import parse_world

WORLD = """
mjsim: 1
name: arms
robots:
  - name: r
    base: fixed
    at: [1, 2]
    arms:
      - {name: big, preset: puma560}
      - {name: small, at: [0, 0.5, 1], dh: {rows: [{a: 0.2}, {slide: true, range: [0, 1], alpha_deg: 90}]}}
  - {name: scout, preset: pioneer3dx, at: [-1, 0]}
run:
  seconds: 1
  drivers:
    r:
      navigator: {use: "mjsim.algorithms.joint_path:JointPath", arm: big, to_deg: [20, 10, -20, 0, 0, 0], seconds: 0.8}
"""


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A recording, and the true motion at each tick of it."""
    world, moved = parse_world(WORLD), []
    path = tmp_path_factory.mktemp("arms") / "run.mcap"
    with mjsim.Simulation(world) as sim:
        run = mjsim.run(sim, record=path, watch=lambda tick: moved.append(tick.joints))
    return run, moved


def test_the_tool_of_an_arm_is_a_topic_with_its_pose():
    tool, joints = np.eye(4), {key: np.zeros(1) for key in KEYS}
    tool[:2, :2], tool[:3, 3] = [[0.28, -0.96], [0.96, 0.28]], (1.0, 2.0, 0.5)
    arm, base = (JointMotion(names=("joint1",), **joints, tool=each) for each in (tool, None))
    messages = dict(joint_messages(0.5, {"r/big": arm, "r/drive": base}))
    assert "/r/drive/tool" not in messages
    told = messages["/r/big/tool"]
    assert told["pose"]["position"] == {"x": 1.0, "y": 2.0, "z": 0.5}
    assert [told["pose"]["orientation"][key] for key in "xyzw"] == pytest.approx([0.0, 0.0, 0.6, 0.8])


@pytest.mark.slow
def test_joints_and_tools_are_read_back_exactly(made):
    run, moved = made
    assert set(run.joints) == {"r/big", "r/small"}
    for name, track in run.joints.items():
        for key in KEYS:
            np.testing.assert_array_equal(getattr(track, key), [getattr(motion[name], key) for motion in moved])
        poses = [Pose3.from_matrix(motion[name].tool).as_array() for motion in moved]
        np.testing.assert_array_equal(track.tool, poses)


@pytest.mark.slow
def test_positions_are_those_of_the_state_and_tools_those_of_the_chain(made):
    run, _ = made
    track = run.joints["r/big"]
    np.testing.assert_array_equal(track.positions, run.qpos[:, :6])
    arm = run.world.robots[0].arms[0].arm
    places = arm.fkine(track.positions)[:, :3, 3] + [1, 2, 0]
    np.testing.assert_allclose(track.tool[:, :3], places, atol=1e-12)


def test_observations_and_commands_hold_what_modules_gave_and_were_given(made):
    run, _ = made
    seen = list(run.observations("r"))
    np.testing.assert_array_equal([each.joints["big"].positions for each in seen], run.joints["r/big"].positions)
    command = json.loads(next(islice(run.messages("/r/command"), 5, None)))["command"]
    (goal,) = command["joints"]
    assert goal["arm"] == "big"
    assert len(goal["positions"]) == len(goal["velocities"]) == len(goal["accelerations"]) == 6


def test_a_part_of_a_run_has_its_part_of_the_joints(made):
    run, _ = made
    part = run.between(0.2, 0.4)
    np.testing.assert_array_equal(part.joints["r/big"].tool, run.joints["r/big"].tool[5:11])


@pytest.mark.slow
def test_the_report_says_how_far_joints_were_from_their_goals_and_draws_them(made, tmp_path):
    run, _ = made
    figures = write_report(run, tmp_path)["robots"]["r"]
    track = run.joints["r/big"]
    error = np.abs(track.goal - track.positions)
    assert figures["arms"]["big"]["goal_error"]["joint2"]["max"] == pytest.approx(error[:, 1].max())
    way = np.linalg.norm(np.diff(track.tool[:, :3], axis=0), axis=1).sum()
    assert figures["arms"]["big"]["tool_distance_m"] == pytest.approx(way)
    # A fixed base has nothing to estimate.
    assert figures["odometry_error_m"] is None
    names = {path.name for path in tmp_path.iterdir()}
    assert {f"r_{arm}_{plot}.png" for arm in ("big", "small") for plot in ("joints", "tool", "tool_path")} <= names
    assert "r_path.png" not in names
    assert "r/small</h2>" in (tmp_path / "report.html").read_text()


def test_plots_hold_the_recorded_numbers(made):
    from mjsim.report.arm_plots import arm_plots
    from mjsim.report.arm_statistics import slides_of

    run, _ = made
    track = run.joints["r/small"]
    slides = slides_of(run.world, "r", "small")
    assert slides.tolist() == [False, True]
    plots = arm_plots(run.time, track, slides)
    values, _, _, torques = plots["joints"].axes
    np.testing.assert_allclose(values.lines[0].get_ydata(), np.degrees(track.positions[:, 0]))
    np.testing.assert_allclose(values.lines[1].get_ydata(), track.positions[:, 1])
    np.testing.assert_allclose(torques.lines[1].get_ydata(), track.torques[:, 1])
    assert values.get_ylabel() == "q [deg, m]"
    np.testing.assert_allclose(plots["tool"].axes[2].lines[0].get_ydata(), track.tool[:, 2])


@pytest.mark.slow
def test_two_runs_of_one_seed_have_the_same_bytes_of_joints(made, tmp_path):
    run, _ = made
    world = parse_world(WORLD)
    with mjsim.Simulation(world) as sim:
        again = mjsim.run(sim, drivers=drivers_of(world), record=tmp_path / "again.mcap")
    for topic in ("/r/big/joints", "/r/big/tool", "/r/small/joints"):
        assert list(again.messages(topic)) == list(run.messages(topic))


def test_a_recording_of_other_joints_is_refused_in_one_line(made, tmp_path):
    run, _ = made
    data = run.path.read_bytes()
    world = run.world.source.text.encode()
    fewer = world.replace(b"{a: 0.2}, ", b"").ljust(len(world))
    assert fewer in data.replace(world, fewer)
    broken = tmp_path / "broken.mcap"
    broken.write_bytes(data.replace(world, fewer))
    with pytest.raises(RecordingError) as caught:
        mjsim.read_recording(broken)
    assert "\n" not in str(caught.value)


def test_exports_hold_joints_and_tools_under_the_names_of_robotics(made, tmp_path):
    run, _ = made
    track = run.joints["r/big"]
    run_csv = {path.name: path for path in export_csv(run, tmp_path / "csv")}
    with run_csv["r_joints_big.csv"].open() as stream:
        rows = list(csv.DictReader(stream))
    assert [float(row["time"]) for row in rows] == run.time.tolist()
    for short, key in (("q", "positions"), ("qd", "velocities"), ("qdd", "accelerations"), ("tau", "torques")):
        read = [[float(row[f"joint{number}_{short}"]) for number in range(1, 7)] for row in rows]
        np.testing.assert_array_equal(read, getattr(track, key))
    assert float(rows[-1]["tool_z"]) == track.tool[-1, 2]
    arrays = np.load(export_npz(run, tmp_path / "run.npz"))
    np.testing.assert_array_equal(arrays["r/joints_big/q"], track.positions)
    np.testing.assert_array_equal(arrays["r/joints_small/goal"], run.joints["r/small"].goal)
    arm, base = run.world.robots[0].arms[0].arm, np.eye(4)
    base[:2, 3] = 1, 2
    np.testing.assert_allclose(arrays["r/joints_big/T"], base @ arm.fkine(track.positions), atol=1e-12)
    mat = loadmat(export_mat(run, tmp_path / "run.mat"), simplify_cells=True)
    np.testing.assert_array_equal(mat["robots"]["r"]["joints_big"]["tau"], track.torques)
    assert mat["robots"]["r"]["joints_big"]["T"].shape == (len(run.time), 4, 4)


def test_the_wheels_of_a_base_that_balances_are_drawn_and_exported(tmp_path):
    world = parse_world("mjsim: 1\nrobots: [{name: joe, preset: balancer, at: [0, 0]}]\nrun: {seconds: 0.4}\n")
    with mjsim.Simulation(world) as sim:
        run = mjsim.run(sim, record=tmp_path / "run.mcap")
    arrays = np.load(export_npz(run, tmp_path / "run.npz"))
    np.testing.assert_array_equal(arrays["joe/joints_drive/tau"], run.joints["joe/drive"].torques)
    assert "joe/joints_drive/tool" not in arrays
    assert set(drive_plots(run.time, run.joints["joe/drive"])) == {"wheels"}
