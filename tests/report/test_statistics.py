"""Figures of a recording against counting by hand."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

import mjsim
from mjsim.geometry import Pose, Pose3
from mjsim.record import JointTrack, Landmarks, RobotEvent, Track
from mjsim.report import key_table, write_report
from mjsim.report.consistency import nees_figures
from mjsim.report.statistics import (
    ESTIMATE_FIGURES,
    ODOMETRY_FIGURES,
    lifts,
    recoveries,
    robot_statistics,
    transient_errors,
)
from mjsim.report.statistics import _arms as arms_of
from mjsim.report.statistics import _module_times as module_times
from mjsim.report.statistics import _pose_figures as pose_figures
from mjsim.report.tables import latex_text
from mjsim.world import MoveEvent, OpenEvent

ROOM = """
mjsim: 1
walls:
  - {points: [[0, 0], [6, 0], [6, 4], [0, 4]], closed: true}
  - {points: [[4, 0], [4, 4]]}
obstacles: [{box: [1.0, 0.6, 1.0], at: [2, 1]}]
beacons:
  - {name: east, at: [3.9, 2], heading_deg: 180}
  - {name: north, at: [2, 3.9], heading_deg: -90}
robots: [{name: scout, at: [0.8, 2.5], body: {radius: 0.2}}]
"""


def track(**parts):
    """A robot that drives 2 m east while the estimate stays 0.1 m to its left."""
    count = 51
    truth = np.column_stack([np.linspace(0.8, 2.8, count), np.full(count, 2.5), np.zeros(count)])
    values = {
        "time": np.arange(count) * 0.04,
        "truth": truth,
        "truth_pose": np.tile(Pose3.from_planar(Pose(0.0, 0.0, 0.0)).as_array(), (count, 1)),
        "odometry": truth + np.array([0.2, 0.0, 0.0]),
        "odometry_covariance": np.tile(np.eye(3), (count, 1, 1)),
        "estimate": truth + np.array([0.0, 0.1, np.radians(2.0)]),
        "covariance": np.tile(np.diag([0.01, 0.01, 1.0]), (count, 1, 1)),
        "command": np.zeros((count, 3)),
        "landmarks": Landmarks(names=(), mean=np.zeros((count, 0, 2)), covariance=np.zeros((count, 0, 2, 2))),
        "sightings": ((),) * count,
        "innovations": ((),) * count,
        "events": (),
    }
    return Track(**(values | parts))


def test_errors_are_those_of_a_constant_offset():
    figures = robot_statistics(mjsim.parse_world(ROOM), "scout", track())
    same = dict.fromkeys(("mean", "rmse", "max", "final"))
    assert figures["position_error_m"] == pytest.approx(dict.fromkeys(same, 0.1))
    assert figures["odometry_error_m"] == pytest.approx(dict.fromkeys(same, 0.2))
    assert figures["heading_error_deg"] == pytest.approx(dict.fromkeys(same, 2.0))
    assert figures["ate_m"]["rmse"] == pytest.approx(0.0, abs=1e-9)
    assert figures["distance_m"] == pytest.approx(2.0)
    assert figures["nees"]["mean"] == pytest.approx(1.0 + np.radians(2.0) ** 2)


def test_ticks_without_an_estimate_have_no_error_but_a_distance():
    torn = track().estimate
    torn[:10] = np.nan
    figures = robot_statistics(mjsim.parse_world(ROOM), "scout", track(estimate=torn))
    assert (figures["ticks"], figures["distance_m"]) == (41, pytest.approx(2.0))
    assert figures["position_error_m"]["mean"] == pytest.approx(0.1)


def test_only_the_robot_whose_base_is_fixed_has_no_errors():
    two = ROOM.replace("robots: [", "robots: [{name: crane, at: [3, 3.2], base: fixed}, ")
    figures = {name: robot_statistics(mjsim.parse_world(two), name, track()) for name in ("scout", "crane")}
    assert [figures[name]["position_error_m"] is None for name in ("scout", "crane")] == [False, True]


def test_times_of_modules_are_in_milliseconds_and_a_tick_is_the_sum_of_its_parts():
    rows = np.arange(101.0) / 1e3
    seconds = {"r/estimator": rows, "loop/step": np.where(rows < 0.05, np.nan, 2.0 * rows), "r/idle": np.nan * rows}
    figures = module_times(SimpleNamespace(module_seconds=seconds))
    assert figures["r/estimator"] == pytest.approx({"mean": 50.0, "p99": 99.0})
    assert figures["loop/step"]["mean"] == pytest.approx(150.0)
    assert figures["tick"] == pytest.approx({"mean": 50.0 + 150.0 * 51 / 101, "p99": 297.0})
    assert set(figures) == {"r/estimator", "loop/step", "tick"}


def test_a_lift_is_no_driven_distance_and_the_step_after_it_is():
    carried = track().truth
    carried[25:] += [1.5, 0.0, 0.0]
    world, moved = mjsim.parse_world(ROOM), track(truth=carried, estimate=carried + np.array([0.0, 0.1, 0.0]))
    assert robot_statistics(world, "scout", moved)["distance_m"] == pytest.approx(3.5)
    figures = robot_statistics(world, "scout", moved, lifted=[25 * 0.04])
    assert figures["distance_m"] == pytest.approx(2.0 - 0.04)
    assert figures["recovery"] == [{"time_s": 1.0, "after_s": 0.0}]


def test_lifts_are_the_moves_of_a_robot_from_the_first_tick_on():
    moves = [MoveEvent(time=at, move=name, to=(1.0, 1.0)) for at in (1.0, 2.0, 3.0) for name in ("scout", "post")]
    events = (*moves, OpenEvent(time=4.0, open="scout"))
    assert lifts(SimpleNamespace(time=np.array([2.0, 5.0]), events=events), "scout") == [2.0, 3.0]


def test_an_estimate_that_turns_too_far_has_the_excess_over_a_metre_as_its_relative_error():
    truth = track().truth
    bent = truth + np.array([0.0, 0.0, 0.1]) * (truth[:, :1] - 0.8)
    figures = robot_statistics(mjsim.parse_world(ROOM), "scout", track(estimate=bent))
    assert figures["rpe_deg"]["mean"] == pytest.approx(np.degrees(0.1), rel=0.05)
    assert figures["heading_error_deg"]["final"] == pytest.approx(np.degrees(0.2))


def test_figures_of_odometry_need_all_of_it_and_no_others_do():
    torn = track().odometry
    torn[7, 2] = np.nan
    whole, figures = (
        robot_statistics(mjsim.parse_world(ROOM), "scout", each) for each in (track(), track(odometry=torn))
    )
    assert {key for key in ESTIMATE_FIGURES if figures[key] is None and whole[key] is not None} == set(ODOMETRY_FIGURES)


def test_a_final_path_is_compared_with_the_truth_of_its_own_times():
    # The ticks are 0.03 s after the poses; the path is right at the times of its poses.
    moment = track().time - 0.03
    path = np.column_stack([moment[5:20] + 0.01, track().truth[5:20] + np.array([0.01, 0.0, 0.0])])
    figures = robot_statistics(mjsim.parse_world(ROOM), "scout", track(moment=moment, path=path))
    assert figures["path_error_m"]["max"] == pytest.approx(0.0, abs=1e-12)
    assert figures["path_heading_error_deg"]["max"] == pytest.approx(0.0, abs=1e-12)


def test_beacons_that_move_have_no_place_in_a_map_and_are_not_false():
    world = mjsim.parse_world(ROOM.replace("beacons:", "beacons:\n  - {name: cap, at: [0, 0], on: scout, center: 0.6}"))
    mean = np.tile([[3.9, 2.3], [1.0, 2.5]], (51, 1, 1))
    marks = Landmarks(names=("east", "cap"), mean=mean, covariance=np.zeros((51, 2, 2, 2)))
    figures = robot_statistics(world, "scout", track(landmarks=marks))["landmark_error_m"]
    assert (figures["count"], figures["false"], figures["rms"]) == (1, 0, pytest.approx(0.3))


def test_arms_are_those_of_their_robot_without_the_wheels_of_a_base():
    rows = np.zeros((3, 1))
    one = JointTrack(
        names=("j",),
        positions=rows,
        velocities=rows,
        accelerations=rows,
        torques=rows - 2.0,
        goal=rows + 0.1,
        tool=np.zeros((3, 7)),
    )
    joints = {"scout/left": one, "scout/drive": one, "other/right": one, "gate": one}
    figures = arms_of(SimpleNamespace(joints=joints), "scout")["arms"]
    assert list(figures) == ["left"]
    assert figures["left"]["torque_max"] == {"j": 2.0}
    assert arms_of(SimpleNamespace(joints=joints), "idle") == {}


def test_bumps_are_counted_and_other_events_are_not():
    events = tuple(RobotEvent(float(k), kind, "") for k, kind in enumerate(("bump", "blocked", "bump")))
    assert robot_statistics(mjsim.parse_world(ROOM), "scout", track(events=events))["bumps"] == 2


def test_the_last_map_is_measured_and_names_that_hang_nowhere_are_false():
    mean = np.full((51, 3, 2), np.nan)
    mean[10:] = [[3.9, 2.3], [2.4, 3.9], [9.0, 9.0]]
    marks = Landmarks(names=("east", "north", "ghost"), mean=mean, covariance=np.zeros((51, 3, 2, 2)))
    figures = robot_statistics(mjsim.parse_world(ROOM), "scout", track(landmarks=marks))["landmark_error_m"]
    assert figures["count"] == 3
    assert figures["false"] == 1
    assert figures["rms"] == pytest.approx(np.sqrt((0.3**2 + 0.4**2) / 2))
    # Two points can only differ in distance after alignment: half of the difference at each.
    apart = np.hypot(1.9, 1.9), np.hypot(1.5, 1.6)
    assert figures["aligned_rms"] == pytest.approx((apart[0] - apart[1]) / 2)


def test_ticks_with_a_singular_covariance_are_left_out_and_counted():
    figures = nees_figures(np.array([np.nan, 1.0, 20.0]))
    assert (figures["mean"], figures["in_band"], figures["singular"]) == (10.5, 0.5, 1)


def test_innovations_are_normalised_by_their_covariance():
    one = ("east", np.array([0.1, 0.0]), np.diag([0.01, 1.0]))
    figures = robot_statistics(mjsim.parse_world(ROOM), "scout", track(innovations=((one, one), *((),) * 50)))
    assert figures["nis"]["mean"] == pytest.approx(1.0)
    assert (figures["nis"]["count"], figures["nis"]["in_band"]) == (2, 1.0)


def test_statistics_are_json_and_hold_the_run(tmp_path):
    with mjsim.Simulation(mjsim.parse_world(ROOM)) as sim:
        figures = mjsim.statistics(mjsim.run(sim, seconds=1.0))
    assert json.loads(json.dumps(figures)) == figures
    assert figures["run"]["sim_seconds"] == pytest.approx(1.0)
    assert figures["run"]["real_time_factor"] == pytest.approx(1.0 / figures["run"]["wall_seconds"])
    assert set(figures["scout"]) >= {
        "position_error_m", "odometry_error_m", "heading_error_deg", "ate_m", "rpe_m", "nees", "nis",
        "landmark_error_m", "distance_m", "coverage", "bumps",
    }  # fmt: skip


@pytest.mark.slow
def test_a_robot_that_nothing_drove_has_no_errors_but_a_report(tmp_path):
    two = ROOM.replace("robots: [", "robots: [{name: idle, at: [0.8, 1.2]}, ")
    with mjsim.Simulation(mjsim.parse_world(two)) as sim:
        recording = mjsim.run(sim, drivers={"scout": mjsim.Driver()}, seconds=1.0)
    figures = write_report(recording, tmp_path)["robots"]
    assert figures["idle"]["position_error_m"] is None
    assert figures["idle"]["distance_m"] < 0.01
    assert figures["scout"]["position_error_m"] is not None
    assert "NaN" not in (tmp_path / "statistics.json").read_text()
    lines = key_table({"robots": figures, "run": {"real_time_factor": None}})
    assert [line for line in lines if line.startswith(("idle", "  distance"))] == [
        "idle                                estimate  odometry",
        "  distance driven [m]                    0.0",
        "  distance driven [m]                    0.0",
    ]


def plain(figures):
    """Return figures as their file holds them; raises ValueError for NaN."""
    return json.loads(json.dumps(figures, allow_nan=False))


def one_tick(**parts):
    """The first tick of a track."""
    values = track()
    arrays = ("time", "truth", "truth_pose", "odometry", "odometry_covariance", "estimate", "covariance", "command")
    marks = Landmarks(names=(), mean=np.zeros((1, 0, 2)), covariance=np.zeros((1, 0, 2, 2)))
    first = {name: getattr(values, name)[:1] for name in arrays}
    return track(**first, landmarks=marks, sightings=((),), innovations=((),), **parts)


def test_a_single_tick_has_errors_but_no_alignment_and_no_stretch():
    figures = plain(robot_statistics(mjsim.parse_world(ROOM), "scout", one_tick()))
    assert figures["position_error_m"]["mean"] == pytest.approx(0.1)
    assert figures["ate_m"] == dict.fromkeys(("rmse", "mean", "median", "max", "min", "std"))
    assert figures["rpe_m"]["rmse"] is None
    assert figures["nis"]["mean"] is None
    assert figures["distance_m"] == 0.0
    assert figures["transient"]["until_s"] == [0.0]


def test_a_robot_that_stands_still_has_no_relative_error_and_its_alignment_is_a_shift():
    still = np.tile([0.8, 2.5, 0.0], (51, 1))
    given = track(truth=still, odometry=still, estimate=still + np.array([0.1, 0.0, 0.0]))
    figures = plain(robot_statistics(mjsim.parse_world(ROOM), "scout", given))
    assert figures["ate_m"]["max"] == pytest.approx(0.0, abs=1e-12)
    assert figures["odometry_rpe_m"]["rmse"] is None
    assert figures["nees"]["mean"] == pytest.approx(1.0)


def test_innovations_and_estimates_with_singular_covariances_are_counted_not_followed():
    singular = ("east", np.array([0.1, 0.0]), np.zeros((2, 2)))
    sound = ("east", np.array([0.1, 0.0]), np.eye(2))
    covariance = np.zeros((51, 3, 3))
    given = track(innovations=((singular, sound), *((),) * 50), covariance=covariance)
    figures = plain(robot_statistics(mjsim.parse_world(ROOM), "scout", given))
    assert (figures["nis"]["count"], figures["nis"]["singular"]) == (2, 1)
    assert figures["nis"]["mean"] == pytest.approx(0.01)
    assert (figures["nees"]["mean"], figures["nees"]["singular"]) == (None, 51)


def test_ticks_without_truth_are_left_out():
    whole = track()
    truth = whole.truth.copy()
    truth[::2] = np.nan
    figures = plain(robot_statistics(mjsim.parse_world(ROOM), "scout", track(truth=truth)))
    assert figures["ticks"] == 25
    assert figures["position_error_m"]["mean"] == pytest.approx(0.1)
    assert figures["distance_m"] == pytest.approx(24 * 0.08)


def test_a_lifted_robot_is_found_again_when_its_error_stays_within_half_a_metre():
    time = np.arange(10.0)
    errors = np.array([0.0, 0.0, 3.0, 0.2, 2.0, 0.4, 0.1, 5.0, 5.0, 5.0])
    assert recoveries(time, errors, [2.0, 7.0]) == [{"time_s": 2.0, "after_s": 3.0}, {"time_s": 7.0, "after_s": None}]


def test_transient_errors_are_means_over_tenths_of_the_run():
    errors = np.repeat(np.arange(10.0), 7)
    figures = transient_errors(np.arange(70.0), errors, 2.0 * errors)
    assert figures["position_error_m"] == list(range(10))
    assert figures["heading_error_deg"] == list(range(0, 20, 2))
    assert figures["until_s"] == [6.0 + 7.0 * k for k in range(10)]


class Failing:
    """Believes the wheels for a second, then fails."""

    def start(self, robot, catalogue, rng):
        self.prior = robot.prior

    def update(self, seen):
        if seen.time > 1.0:
            raise RuntimeError("lost")
        return mjsim.Estimate(self.prior, np.eye(3))


@pytest.mark.slow
def test_a_run_that_a_fault_ended_and_a_file_that_was_cut_have_statistics_that_say_so(tmp_path):
    path = tmp_path / "run.mcap"
    with mjsim.Simulation(mjsim.parse_world(ROOM)) as sim, pytest.raises(mjsim.ModuleFault):
        mjsim.run(sim, drivers={"scout": mjsim.Driver(estimator=Failing())}, seconds=3.0, record=path)
    figures = plain(write_report(mjsim.read_recording(path), tmp_path / "report"))
    assert "RuntimeError: lost" in figures["robots"]["scout"]["fault"]
    assert figures["run"]["whole"]
    assert figures["run"]["sim_seconds"] < figures["run"]["asked_seconds"] == 3.0
    assert "lost" in (tmp_path / "report" / "report.html").read_text()
    data = path.read_bytes()
    path.write_bytes(data[: len(data) * 2 // 3])
    assert not mjsim.statistics(mjsim.read_recording(path))["run"]["whole"]


def test_what_latex_takes_for_commands_is_escaped():
    assert latex_text("a_b & 5% {x} #1 $ ~ ^ \\") == (
        r"a\_b \& 5\% \{x\} \#1 \$ \textasciitilde{} \textasciicircum{} \textbackslash{}"
    )


class Lost:
    """Believes to be where no robot can be, and to know it badly."""

    def start(self, robot, catalogue, rng):
        """Need nothing."""

    def update(self, seen):
        return mjsim.Estimate(mjsim.Pose(1e200, 0.0, 0.0), np.diag([1e-300, 1e300, 1.0]))


def test_an_estimate_beyond_all_numbers_gives_null_where_a_figure_overflows():
    with mjsim.Simulation(mjsim.parse_world(ROOM)) as sim:
        figures = plain(
            mjsim.statistics(mjsim.run(sim, drivers={"scout": mjsim.Driver(estimator=Lost())}, seconds=0.2))
        )
    assert figures["scout"]["position_error_m"]["max"] == pytest.approx(1e200)
    assert figures["scout"]["position_error_m"]["rmse"] is None
    assert figures["scout"]["nees"] | {"band": None} == {
        "mean": None, "in_band": None, "band": None, "mean_band": None, "singular": 5, "independent": None,
        "reason": "no covariance is regular",
    }  # fmt: skip


def test_height_and_lean_are_those_of_the_poses():
    from scipy.spatial.transform import Rotation

    roll, pitch = np.radians([[1.0, -3.0], [2.0, 6.0]])
    quaternions = Rotation.from_euler("xyz", np.column_stack([roll, pitch, [0.4, 0.9]])).as_quat()
    found = pose_figures(np.column_stack([np.zeros((2, 2)), [0.1, 0.3], quaternions]))
    height = {"rmse": np.sqrt(0.05), "mean": 0.2, "median": 0.2, "max": 0.3, "min": 0.1, "std": 0.1}
    assert found["height_m"] == pytest.approx(height)
    assert (found["roll_deg"]["max"], found["roll_deg"]["min"]) == pytest.approx((1.0, -3.0))
    assert found["pitch_deg"]["mean"] == pytest.approx(4.0)
    assert pose_figures(np.zeros((0, 7))) == dict.fromkeys(("height_m", "roll_deg", "pitch_deg"))


def test_the_table_of_a_terminal_has_a_head_for_each_robot_and_what_ended_it():
    figures = robot_statistics(mjsim.parse_world(ROOM), "scout", track())
    lines = key_table({"robots": {"scout": {**figures, "fault": "a stop"}}, "run": {"real_time_factor": 2.34}})
    assert lines[0] == "scout                               estimate  odometry"
    assert next(line.split() for line in lines if "distance driven" in line)[-1] == "2.0"
    row = next(line.split() for line in lines if line.startswith("  position error, mean"))
    assert row[-2:] == ["0.100", "0.200"]
    assert "  ended by a fault: a stop" in lines
    assert lines[-1].split() == ["real-time", "factor", "of", "the", "run", "2.3"]
