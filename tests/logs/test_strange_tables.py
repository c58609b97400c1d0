"""Tables as other programs write them: lines before the names, dates, quaternions, motion to the side."""

import math
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest

from mjsim.errors import MjsimError
from mjsim.geometry import Pose
from tests.real_logs import imported

TURN = 0.3
POSES = [(0.1 * k, math.sin(TURN * 0.1 * k), 1.0 - math.cos(TURN * 0.1 * k), TURN * 0.1 * k) for k in range(40)]


def end_of(folder, keys: str, text: str, *, kind: str = "odometry", more: str = "") -> Pose:
    """Return where the robot of a table ends by its odometry."""
    (folder / "o.csv").write_text(text, newline="")
    (folder / "log.yaml").write_text(f"log: tables\n{kind}: {{file: o.csv, {keys}}}\n{more}")
    place = Pose(0.0, 0.0, 0.0)
    for seen in imported(folder / "log.yaml").observations("robot"):
        place = place @ Pose(seen.odometry.forward, seen.odometry.left, seen.odometry.turn)
    return place


def rows(line) -> str:
    """Return the lines of a table of poses."""
    return "".join(f"{line(*pose)}\n" for pose in POSES)


def plain(t, x, y, h) -> str:
    return f"{t},{x},{y},{h}"


def quaternion(t, x, y, h) -> str:
    # Rolled by half a turn: the robot hangs, its x axis points as the heading says.
    return f"{t},{x},{y},{math.cos(h / 2)},{math.sin(h / 2)},0,0"


def dated(zone: str):
    since = datetime(2026, 3, 29, 0, 59, 59, tzinfo=UTC)  # Clocks are put forward a second later.
    return lambda t, *pose: f"{(since + timedelta(seconds=t)).isoformat()[:-6]}{zone},{','.join(map(str, pose))}"


@pytest.mark.parametrize(
    ("keys", "text"),
    [
        ("skip: 3, time: t, x: x, y: y, heading: h", "Robot: R2D2, 5\nDate: today\n\nt,x,y,h\n" + rows(plain)),
        ("skip: 2, time: 1, x: 2, y: 3, heading: 4", "t,x,y,h\n[s],[m],[m],[rad]\n" + rows(plain)),
        ("time: t, x: x, y: y, heading: h", "sep=,\r\nt,x,y,h\n" + rows(plain)),
        ("time: t, x: x, y: y, heading: h", "t,x,y,h\n" + rows(dated(""))),
        ("time: t, x: x, y: y, heading: h", "t,x,y,h\n" + rows(dated("Z"))),
        ("time: t, x: x, y: y, heading: h", "t,x,y,h\n" + rows(dated("+02:00"))),
        ("time: t, x: x, y: y, quaternion: [a, b, c, d]", "t,x,y,a,b,c,d\n" + rows(quaternion)),
    ],
)
def test_a_table_tells_where_the_robot_is(keys, text, tmp_path):
    end = end_of(tmp_path, keys, text)
    np.testing.assert_allclose([end.x, end.y, end.heading], POSES[-1][1:], atol=1e-9)


def test_velocities_may_have_a_part_to_the_left(tmp_path):
    text = "t;v;l;w\n" + "".join(f"{100 * k};50;10;{math.degrees(TURN)}\n" for k in range(40))
    keys = "time: t, forward: v, left: l, turn_deg: w"
    end = end_of(tmp_path, keys, text, kind="twist", more="time_unit: ms\nlength_unit: cm\n")
    angle = TURN * 3.9
    s, c = math.sin(angle), 1.0 - math.cos(angle)
    expected = [(0.5 * s - 0.1 * c) / TURN, (0.5 * c + 0.1 * s) / TURN, angle]
    np.testing.assert_allclose([end.x, end.y, end.heading], expected, atol=1e-9)


def test_a_gyroscope_may_tell_degrees(tmp_path):
    text = "t,ax,ay,az,p,q,r\n" + "".join(f"{0.01 * k},0,0,9.8,{k},-90,180\n" for k in range(100))
    (tmp_path / "i.csv").write_text(text)
    told = "log: tables\nimu: {file: i.csv, time: t, acceleration: [ax, ay, az], turn_deg: [p, q, r]}\n"
    (tmp_path / "log.yaml").write_text(told)
    seen = list(imported(tmp_path / "log.yaml").observations("robot"))
    turns = np.array([reading.turn for each in seen for reading in each.imu])
    np.testing.assert_allclose(turns[:, 1:], np.tile([-math.pi / 2, math.pi], (100, 1)))
    np.testing.assert_allclose(turns[:, 0], np.radians(np.arange(100)))


@pytest.mark.parametrize(
    ("keys", "text", "said"),
    [
        ("time: t, x: x, y: y", rows(plain), "name one of heading [rad], heading_deg and quaternion"),
        ("time: t, x: x, y: y, heading: h, quaternion: [a, b, c, d]", rows(plain), "name one of heading [rad]"),
        ("time: t, x: x, y: y, heading: h", "t,x,y,h\n12:00:01,0,0,0\n", "write a number, or 2026-01-31T12:00"),
        ("time: t, x: x, y: y, quaternion: [x, y, h, h]", "t,x,y,h\n0,0,0,0\n", "o.csv:2: the quaternion has length 0"),
        (
            "time: t, x: x, y: y, heading: h",
            "Run 5\nt,x,y,h\n" + rows(plain),
            "say how many lines are before",
        ),
    ],
)
def test_a_table_that_is_not_clear_is_one_line(keys, text, said, tmp_path):
    with pytest.raises(MjsimError) as caught:
        end_of(tmp_path, keys, text)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_rows_out_of_order_are_sorted_and_reported(tmp_path):
    lines = rows(plain).splitlines()
    (tmp_path / "o.csv").write_text("\n".join(["t,x,y,h", *lines[:10], *lines[20:], *lines[10:20]]))
    (tmp_path / "log.yaml").write_text("log: tables\nodometry: {file: o.csv, time: t, x: x, y: y, heading: h}\n")
    run = imported(tmp_path / "log.yaml")
    assert run.metadata["clock of o.csv"] == "mended: set back 1 times; the rows are sorted by time"
    assert sum(seen.odometry.turn for seen in run.observations("robot")) == pytest.approx(TURN * 3.9)
