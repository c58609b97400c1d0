"""Tables and folders as people leave them: names with blanks, empty cells, a description with a comment."""

import os
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import mjsim
from mjsim.algorithms.ekf_slam.ekf_slam import EkfSlam
from mjsim.errors import MjsimError, UsageError
from tests.real_logs import imported

TIMES = [0.1 * k for k in range(20)]
DRIVEN = "t,x,y,yaw\n" + "".join(f"{t:.1f},{0.5 * t:.3f},0,0\n" for t in TIMES)
LOG = "log: tables\nodometry: {file: odometry.csv, time: t, x: x, y: y, heading: yaw}\n"
SCANS = "scans: [{file: scan.csv, time: t, ranges: r, from_deg: -90, step_deg: 90, range: [0.1, 8]}]\n"


def write(folder: Path, text: str = LOG, **tables: str) -> Path:
    """Write a description and tables by the names of their files; return the former."""
    (folder / "odometry.csv").write_text(DRIVEN)
    for name, content in tables.items():
        (folder / f"{name}.csv").write_text(content)
    (folder / "log.yaml").write_text(text)
    return folder / "log.yaml"


def way(run: mjsim.Recording) -> float:
    return sum(seen.odometry.forward for seen in run.observations("robot"))


@pytest.mark.parametrize(
    "first", ["log: tables  # mine", 'log: "tables"', "'log': 'tables'", "--- # a log\nlog: tables"]
)
def test_a_description_is_known_however_it_is_written(first, tmp_path):
    assert way(imported(write(tmp_path, LOG.replace("log: tables", first)))) == pytest.approx(0.95)


def test_a_description_in_braces_is_known(tmp_path):
    text = "{log: tables, odometry: {file: odometry.csv, time: t, x: x, y: y, heading: yaw}}\n"
    assert way(imported(write(tmp_path, text))) == pytest.approx(0.95)


def test_a_folder_that_holds_one_log_stands_for_it(tmp_path):
    write(tmp_path)
    (tmp_path / "notes.txt").write_text("The floor was wet.\n")
    run = imported(tmp_path)
    assert way(run) == pytest.approx(0.95)
    assert run.metadata["log source"] == str(tmp_path / "log.yaml")
    (tmp_path / "drive.log").write_text("ODOM 0 0 0 0 0 0 1 host 1\n" * 3)
    with pytest.raises(UsageError, match=r"is a folder of logs; name one of them: drive\.log, log\.yaml$"):
        imported(tmp_path)


def test_landmarks_may_have_any_names_and_sightings_none(tmp_path):
    seen = "t,what,r,b\n" + "".join(
        f"{t:.1f},Tür 7/ä,{2.0 - 0.5 * t:.3f},0\n{t:.1f},,1.0,{np.pi / 2:.6f}\n" for t in TIMES
    )
    text = LOG + (
        "sightings: {file: seen.csv, time: t, name: what, range: r, bearing: b}\n"
        "landmarks: {file: marks.csv, name: id, x: x, y: y}\n"
    )
    run = imported(write(tmp_path, text, seen=seen, marks="id,x,y\nTür 7/ä,2,0\n"))
    assert [beacon.name for beacon in run.world.beacons] == ["T_r_7__"]
    names = {sighting.name for each in run.observations("robot") for sighting in each.sightings}
    assert names == {"T_r_7__", None}
    assert mjsim.replay(run, robot="robot", estimator=EkfSlam()).whole


def test_a_cell_of_a_scan_that_is_empty_is_not_a_number(tmp_path):
    scan = "t,r0,r1,r2\n" + "".join(f"{t:.1f},,2.5,9\n" for t in TIMES)
    run = imported(write(tmp_path, LOG + SCANS, scan=scan))
    ranges = next(seen.scans["scan"].ranges for seen in run.observations("robot") if seen.scans)
    np.testing.assert_array_equal(ranges, [-np.inf, 2.5, np.inf])


def test_a_truth_that_does_not_overlap_the_log_is_reported(tmp_path):
    text = f"{LOG}truth: {{file: truth.csv, time: t, x: x, y: y, heading: yaw}}\n"
    run = imported(write(tmp_path, text, truth="t,x,y,yaw\n1000,0,0,0\n1001.5,0,0,0\n"))
    assert (
        run.metadata["truth of robot left out"] == "all of it is from 1000 to 1001.5 s, readings from 0 to 1.999999 s"
    )


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("[0.1, 8]", "[8, 0.1]", r"log\.yaml:3:9: range is \[8, 0\.1\] m; the nearest must be less than the farthest$"),
        ("step_deg: 90", "step_deg: 0", r"log\.yaml:3:9: step_deg is 0; it is the angle from one beam to the next"),
        (
            "file: odometry.csv, time: t",
            "file: odometry.csv, time: 0",
            r"log\.yaml:2:38: there is no column 0; columns",
        ),
        (
            "ranges: r",
            'ranges: ""',
            r"log\.yaml:3:43: a column name of 0 characters; give its name, or its number, counted from 1$",
        ),
    ],
)
def test_an_error_is_reported_once_with_its_place_in_the_description(old, new, said, tmp_path):
    path = write(tmp_path, (LOG + SCANS).replace(old, new), scan="t,r0,r1,r2\n0,1,1,1\n1,1,1,1\n")
    with pytest.raises(MjsimError, match=said) as caught:
        imported(path)
    assert "\n" not in str(caught.value)


def test_a_fault_of_a_landmark_or_a_sighting_names_its_line(tmp_path):
    text = f"{LOG}landmarks: {{file: marks.csv, name: id, x: x, y: y}}\n"
    for marks, said in (
        ("id,x,y\na b,1,1\na_b,2,2\n", r"marks\.csv:3: landmark 'a_b' has two positions; each must have one line"),
        ("id,x,y\n,1,1\n", r"marks\.csv:2: a landmark has no name; give it one, or leave the line out"),
    ):
        with pytest.raises(UsageError, match=said):
            imported(write(tmp_path, text, marks=marks))
    text = f"{LOG}sightings: {{file: seen.csv, time: t, range: r, bearing: b}}\n"
    with pytest.raises(UsageError, match=r"seen\.csv:3: a range is 0 m; it must be above 0"):
        imported(write(tmp_path, text, seen="t,r,b\n0,1,0\n1,0,0\n"))


def drive(count: int = 20, *, dt: float = 0.1, **changes) -> list[mjsim.Observation]:
    """Return observations of a drive at an even rate; changes are of the last."""
    moved = mjsim.Odometry(0.02, 0.0, 0.0, np.diag([1e-6, 1e-8, 1e-6]))
    seen = [mjsim.Observation(dt * k, dt, moved) for k in range(count)]
    return [*seen[:-1], replace(seen[-1], **changes)]


@pytest.mark.parametrize("rate", [3.0 + 1.0 / 3.0, 12.5, 20.0, 40.0, 200.0, 250.0])
def test_observations_come_at_any_rate_of_whole_milliseconds(rate, tmp_path):
    run = mjsim.write_log(tmp_path / "own.mcap", drive(dt=1.0 / rate))
    np.testing.assert_allclose(run.time, np.arange(20) / rate, atol=1e-9)


@pytest.mark.parametrize(
    ("observations", "said"),
    [
        (drive(dt=1.0 / 30.0), "a tick must be a whole number of 1 ms steps, the nearest rate is 30.303 Hz"),
        (
            drive(odometry=mjsim.Odometry(np.nan, 0.0, 0.0, np.eye(3))),
            "observation 19: its odometry holds a number that",
        ),
        (drive(odometry=mjsim.Odometry(0.0, 0.0, 0.0, np.eye(2))), "has shape (2, 2); it must be (3, 3)"),
        (drive(scans={"my scan": mjsim.Scan(1.9, np.ones(3), 0.0, 0.1, 0.1, 8.0)}), "recorded: lidar is 'my scan'"),
        (
            drive(scans={"scan": mjsim.Scan(1.9, np.ones(3), 0.0, 0.1, 0.1, np.inf)}),
            "limits of scan 'scan' are not finite",
        ),
        (drive(scans={"scan": mjsim.Scan(1.9, [1.0, 2.0], 0.0, 0.1, 0.1, 8.0)}), "of scan 'scan' are not an array"),
        (
            drive(sightings=(mjsim.Sighting(1.9, "a", np.nan, 0.0, np.eye(2)),)),
            "19: a sighting has range nan m",
        ),
        (
            drive(sightings=(mjsim.Sighting(1.9, "a", -1.0, 0.0, np.eye(2)),)),
            "19: a sighting has range -1 m",
        ),
        (drive(sightings=(mjsim.Sighting(1.9, 7, 1.0, 0.0, np.eye(2)),)), "a sighting has the name 7; it is a text"),
        (
            drive(sightings=(mjsim.Sighting(1.9, "a", 1.0, 0.0, np.eye(3)),)),
            "covariance of a sighting is not (2, 2)",
        ),
        (drive(odometry=mjsim.Odometry(0.0, 0.0, 0.0, -np.eye(3))), "its odometry has a variance below 0"),
        (
            drive(imu=(mjsim.ImuReading(1.9, [0, 0, 9.8], np.zeros(3)),)),
            "19: the acceleration of an inertial reading",
        ),
        (
            drive(scans={"scan": mjsim.Scan(1.9, np.ones((2, 2)), 0.0, 0.1, 0.1, 8.0)}),
            "the ranges of scan 'scan' have shape (2, 2); it must be (n,)",
        ),
    ],
)
def test_an_observation_that_cannot_be_recorded_is_named_and_leaves_no_file(observations, said, tmp_path):
    with pytest.raises(MjsimError, match=re.escape(said)) as caught:
        mjsim.write_log(tmp_path / "own.mcap", observations)
    assert "world.yaml" not in str(caught.value)
    assert list(tmp_path.iterdir()) == []


def test_lines_may_end_with_a_carriage_return_alone(tmp_path):
    description = write(tmp_path)
    (tmp_path / "odometry.csv").write_bytes(DRIVEN.replace("\n", "\r").encode())
    assert way(imported(description)) == pytest.approx(0.95)
    lines = [f"ODOM {0.05 * k:.3f} 0 0 0.5 0 0 {k / 10:.1f} host {k / 10:.1f}\r" for k in range(20)]
    (tmp_path / "drive.clf").write_bytes("".join(lines).encode())
    assert way(imported(tmp_path / "drive.clf")) == pytest.approx(0.95)


def test_links_that_lead_in_a_circle_and_pipes_are_told(tmp_path):
    description = write(tmp_path)
    (tmp_path / "odometry.csv").unlink()
    (tmp_path / "odometry.csv").symlink_to("odometry.csv")
    with pytest.raises(UsageError, match=r"cannot read '.*odometry\.csv': Too many levels of symbolic links"):
        imported(description)
    (tmp_path / "odometry.csv").unlink()
    os.mkfifo(tmp_path / "odometry.csv")
    with pytest.raises(UsageError, match=r"cannot read '.*odometry\.csv': it is not a file; copy its contents into"):
        imported(description)


ROWS = DRIVEN.splitlines()[1:]


@pytest.mark.parametrize(
    ("table", "note"),
    [
        (DRIVEN.replace(",", "|"), {}),
        ("t,x,y,yaw\n" + "".join(f"{row},\n" for row in ROWS), {}),
        (
            "t,x,y,yaw\ns,m,m,rad\n" + "\n".join(ROWS),
            {"line of odometry.csv below the names of columns left out": "s, m, m, rad"},
        ),
        # Several sensors in one table, each with rows of its own.
        (
            "t,x,y,yaw,range\n" + "".join(f"{row},\n{row.partition(',')[0]},,,NaN,7\n" for row in ROWS),
            {"rows of odometry.csv without t, x, y, yaw left out": "20"},
        ),
        ("t, x, y, yaw, note\n" + "".join(f'{row.replace(",", ", ")}, "a, b"\n' for row in ROWS), {}),
        (
            DRIVEN
            + "".join(f"{ROWS[3].partition(',')[0]},{blank},0,0\n" for blank in ("NA", "#N/A", "null", "None", "-")),
            {"rows of odometry.csv without t, x, y, yaw left out": "5"},
        ),
    ],
)
def test_tables_of_other_programs_are_the_same_table(table, note, tmp_path):
    write(tmp_path, odometry=table)
    run = imported(tmp_path / "log.yaml")
    assert way(run) == pytest.approx(0.95)
    assert {fact: value for fact, value in run.metadata.items() if "odometry.csv" in fact} == note


@pytest.mark.parametrize("unit", ["", "time_unit: ms\n"])
def test_times_that_are_too_late_for_their_unit_are_one_line(unit, tmp_path):
    stamped = "".join(f"{1_700_000_000_000 + 100 * k}{'000' if unit else ''},{0.05 * k},0,0\n" for k in range(20))
    (tmp_path / "o.csv").write_text("t,x,y,yaw\n" + stamped)
    (tmp_path / "log.yaml").write_text(
        f"log: tables\n{unit}odometry: {{file: o.csv, time: t, x: x, y: y, heading: yaw}}\n"
    )
    with pytest.raises(UsageError, match=r"o\.csv:2: t is 17\d+, 1\.7e\+12 s; give its time_unit \(ms, us or ns\)"):
        imported(tmp_path / "log.yaml")


def test_times_that_are_too_close_for_their_unit_are_one_line(tmp_path):
    stamped = "".join(f"{100 * k},{0.05 * k},0,0\n" for k in range(20))
    write(tmp_path, LOG + "time_unit: ns\n", odometry="t,x,y,yaw\n" + stamped)
    with pytest.raises(UsageError, match=r"odometry\.csv:2: its 20 rows last 1\.9e-06 s; give its time_unit"):
        imported(tmp_path / "log.yaml")


def test_a_table_without_a_value_in_a_column_that_is_needed_is_one_line(tmp_path):
    write(tmp_path, odometry="t,x,y,yaw\n" + "".join(f"{k},,0,0\n" for k in range(9)))
    with pytest.raises(UsageError, match=r"odometry\.csv' holds no row with values of t, x, y, yaw; name other"):
        imported(tmp_path / "log.yaml")
