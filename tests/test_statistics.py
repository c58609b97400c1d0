"""Figures of a recording against counting by hand, and coverage against a raster."""

import json

import numpy as np
import pytest
from scipy import ndimage

import mjsim
from mjsim.record import Event, Landmarks, Track
from mjsim.report import key_table, write_report
from mjsim.report.coverage import coverage
from mjsim.report.statistics import nees_figures, robot_statistics
from mjsim.world.plan import solid

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


def test_bumps_are_counted_and_other_events_are_not():
    events = tuple(Event(float(k), kind, "") for k, kind in enumerate(("bump", "blocked", "bump")))
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
    assert nees_figures(np.array([np.nan, 1.0, 20.0])) == {"mean": 10.5, "in_band": 0.5, "singular": 1}


def test_innovations_are_normalised_by_their_covariance():
    one = ("east", np.array([0.1, 0.0]), np.diag([0.01, 1.0]))
    figures = robot_statistics(mjsim.parse_world(ROOM), "scout", track(innovations=((one, one), *((),) * 50)))
    assert figures["nis"] == {"mean": pytest.approx(1.0), "count": 2}


def raster_coverage(world, positions, radius, *, step=0.01):
    """Count cells on a fine raster: flood fill for reach, distance to every position for touch."""
    import shapely

    things = solid(world)
    west, south, east, north = things.bounds
    x, y = np.arange(west + step / 2, east, step), np.arange(south + step / 2, north, step)
    points = shapely.points(*np.meshgrid(x, y))
    free = shapely.distance(things, points) > radius + 0.15
    labels, _ = ndimage.label(free)
    home = labels[np.searchsorted(y, positions[0, 1]), np.searchsorted(x, positions[0, 0])]
    reached = touched = 0
    for low_x in np.arange(np.floor(west / 0.5), np.ceil(east / 0.5)) * 0.5:
        for low_y in np.arange(np.floor(south / 0.5), np.ceil(north / 0.5)) * 0.5:
            column, row = np.searchsorted(x, low_x + 0.25), np.searchsorted(y, low_y + 0.25)
            if not (column < len(x) and row < len(y) and labels[row, column] == home):
                continue
            reached += 1
            nearest = np.clip(positions, [low_x, low_y], [low_x + 0.5, low_y + 0.5])
            touched += np.hypot(*(positions - nearest).T).min() <= radius
    return touched / reached


def test_coverage_equals_that_of_a_fine_raster():
    world = mjsim.parse_world(ROOM)
    way = np.concatenate([np.linspace([0.8, 2.53], [2.9, 2.53], 400), np.linspace([2.9, 2.53], [3.1, 0.9], 400)])
    share = coverage(world, way, radius=0.2)
    assert share == pytest.approx(raster_coverage(world, way, 0.2), abs=1e-9)
    assert 0.3 < share < 1.0


def test_a_room_that_cannot_be_reached_does_not_count():
    world = mjsim.parse_world(ROOM)
    sweep = np.array([(x, y) for y in np.arange(0.4, 3.7, 0.1) for x in np.arange(0.4, 3.7, 0.1)])
    assert coverage(world, sweep[::-1], radius=0.2) == 1.0


def test_a_world_without_walls_has_no_coverage():
    world = mjsim.parse_world("mjsim: 1\nrobots: [{name: scout, at: [0, 0]}]\n")
    assert coverage(world, np.zeros((2, 2)), radius=0.2) is None


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


def test_a_robot_that_nothing_drove_has_no_errors_but_a_report(tmp_path):
    two = ROOM.replace("robots: [", "robots: [{name: idle, at: [0.8, 1.2]}, ")
    with mjsim.Simulation(mjsim.parse_world(two)) as sim:
        recording = mjsim.run(sim, drivers={"scout": mjsim.Driver()}, seconds=1.0)
    figures = write_report(recording, tmp_path)["robots"]
    assert figures["idle"]["position_error_m"] is None
    assert figures["idle"]["distance_m"] < 0.01
    assert figures["scout"]["position_error_m"] is not None
    assert "NaN" not in (tmp_path / "statistics.json").read_text()
    assert len(key_table({"robots": figures, "run": {"real_time_factor": None}})) == 3 + 14
