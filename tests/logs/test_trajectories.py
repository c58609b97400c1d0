"""Trajectories of other programs are judged on the truth of a recording: TUM files, and poses in bags."""

import json
import math
from datetime import UTC, datetime
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from mjsim import import_log, parse_world
from mjsim.errors import UsageError
from mjsim.geometry import Pose, Pose3
from mjsim.logs import Trajectory, listed_notes, offset_to_run, read_trajectory
from mjsim.logs.trajectory import trajectory_rows
from mjsim.record import export_tum
from mjsim.run import run
from mjsim.sim import Simulation
from tests.bags import new_bag
from tests.real_logs import run_command

ROWS = [(10.0, 1.0, 2.0, math.pi - 0.1), (11.0, 2.0, 2.0, -math.pi + 0.1), (12.0, 2.0, 4.0, 0.5)]


def quaternion(heading: float) -> str:
    return f"0 0 {math.sin(heading / 2)!r} {math.cos(heading / 2)!r}"


def test_rows_of_all_forms_are_read_and_sorted(tmp_path):
    for text in (
        "".join(f"{t} {x} {y} 0.3 {quaternion(turn)}\n" for t, x, y, turn in reversed(ROWS)),
        "".join(f"{t},{x},{y},{turn!r}\n" for t, x, y, turn in [(ROWS[0][0], 9.0, 9.0, 1.0), *ROWS]),
        "".join(f"{t};{x};{y};{turn!r};\n".replace(".", ",") for t, x, y, turn in ROWS),
    ):
        (tmp_path / "track.tum").write_text(f"# a comment\n\n{text}")
        np.testing.assert_allclose(trajectory_rows(tmp_path / "track.tum", None)["rows"][:3, 3].max(), math.pi - 0.1)
        np.testing.assert_allclose(read_trajectory(tmp_path / "track.tum"), ROWS, atol=1e-12)


def test_poses_without_times_of_g2o_and_kitti_come_at_a_period(tmp_path):
    vertices = "".join(f"VERTEX_SE2 {k} {x} {y} {turn!r}\n" for k, (_, x, y, turn) in enumerate(ROWS))
    (tmp_path / "a.g2o").write_text(f"{vertices}EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nFIX 0\n")
    solid = "".join(f"VERTEX_SE3:QUAT {k} {x} {y} 0 {quaternion(turn)}\n" for k, (_, x, y, turn) in enumerate(ROWS))
    (tmp_path / "b.g2o").write_text(f"PARAMS_SE3OFFSET 0 0 0 0 0 0 0 1\n{solid}")
    # A camera looks along z, its x is to the right, its y down.
    body_from_camera = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
    rows = []
    for _, x, y, turn in ROWS:
        body = np.array([[math.cos(turn), -math.sin(turn), 0.0], [math.sin(turn), math.cos(turn), 0.0], [0, 0, 1]])
        camera = body_from_camera.T @ np.column_stack([body @ body_from_camera, (x, y, 0.0)])
        rows.append(" ".join(f"{value:.9f}" for value in camera.ravel()))
    (tmp_path / "c.txt").write_text("\n".join(rows))
    for name in ("a.g2o", "b.g2o", "c.txt"):
        found = read_trajectory(tmp_path / name, period=0.5)
        np.testing.assert_allclose(found, [(0.5 * k, *row[1:]) for k, row in enumerate(ROWS)], atol=1e-8)
        with pytest.raises(
            UsageError, match=r":\d: its poses have no times; give period, the seconds between two poses$"
        ):
            read_trajectory(tmp_path / name)


def test_poses_of_kitti_with_z_up_are_those_of_a_robot(tmp_path):
    for rows in (ROWS, [(t, x, 2.0, 0.0) for t, x, _, _ in ROWS]):
        text = "".join(
            f"{math.cos(h)!r} {-math.sin(h)!r} 0 {x} {math.sin(h)!r} {math.cos(h)!r} 0 {y} 0 0 1 0.1\n"
            for _, x, y, h in rows
        )
        (tmp_path / "up.txt").write_text(text)
        found = read_trajectory(tmp_path / "up.txt", period=0.5)
        np.testing.assert_allclose(found, [(0.5 * k, *row[1:]) for k, row in enumerate(rows)], atol=1e-12)


def test_times_in_nanoseconds_are_known_by_their_header_or_size_and_commas_tell_where_w_is(tmp_path):
    header = "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],q_RS_z []\n"

    def w_first(t, x, y, h):
        return f"{round(1e9 * t)},{x},{y},0,{math.cos(h / 2)!r},0,0,{math.sin(h / 2)!r}\n"

    def w_last(t, x, y, h):
        return f"{round(1e9 * t)} {x} {y} 0 {quaternion(h)}\n"

    for since, text, row in ((0.0, header, w_first), (1.7e9, "", w_first), (1.7e9, "", w_last)):
        rows = [(since + t, *pose) for t, *pose in ROWS]
        (tmp_path / "track.csv").write_text(text + "".join(row(*each) for each in rows))
        np.testing.assert_allclose(read_trajectory(tmp_path / "track.csv"), rows, atol=1e-6)


@pytest.mark.parametrize(("unit", "name"), [(1e9, "ns"), (1e6, "us"), (1.0, "")])
def test_times_since_the_start_are_known_by_their_steps(unit, name, tmp_path):
    text = "".join(f"{(t - 10.0) / 5.0 * unit:.6f} {x} {y} {turn!r}\n" for t, x, y, turn in ROWS)
    (tmp_path / "track.txt").write_text(text)
    notes: dict[str, str] = {}
    found = read_trajectory(tmp_path / "track.txt", notes=notes)
    np.testing.assert_allclose(found[:, 0], [0.0, 0.2, 0.4], atol=1e-9)
    assert listed_notes(notes) == (
        [f"guessed: times of the trajectory: in {name}, by a step of {0.2 * unit:g}"] if name else []
    )


def test_names_in_a_comment_of_matlab_tell_the_columns(tmp_path):
    (tmp_path / "track.txt").write_text("% x\ty\tth\tt\n" + "".join(f"{x}\t{y}\t{h!r}\t{t}\n" for t, x, y, h in ROWS))
    np.testing.assert_allclose(read_trajectory(tmp_path / "track.txt"), ROWS, atol=1e-12)


def of_turn(turn: float) -> dict[str, str]:
    """Return the columns of a heading, as different programs name them."""
    z, w = math.sin(turn / 2), math.cos(turn / 2)
    return {"qx": "0", "qy": "0", "qz": repr(z), "qw": repr(w)}


NAMED = {
    "own": ("theta,y,x,time", lambda t, x, y, h: f"{h!r},{y},{x},{t}"),
    "german": (
        "Zeit;t;x [mm];y [mm];yaw [deg]",
        lambda t, x, y, h: _comma(f"9;{t};{1e3 * x};{1e3 * y};{math.degrees(h)!r}"),
    ),
    "evo, w first": (
        "# timestamp tx ty tz qw qx qy qz",
        lambda t, x, y, h: "{} {} {} 1 {qw} {qx} {qy} {qz}".format(t, x, y, **of_turn(h)),
    ),
    "rostopic": (
        "%time,field.header.seq,field.header.stamp,field.header.frame_id,field.pose.position.x,field.pose.position.y,"
        "field.pose.position.z,field.pose.orientation.x,field.pose.orientation.y,field.pose.orientation.z,"
        "field.pose.orientation.w",
        lambda t, x, y, h: "7,3,{:.0f},map,{},{},0,{qx},{qy},{qz},{qw}".format(1e9 * (1.7e9 + t), x, y, **of_turn(h)),
    ),
    "plotjuggler": (
        "__time,/p/pose/position/x,/p/pose/position/y,/p/pose/orientation/w,/p/pose/orientation/x,"
        "/p/pose/orientation/y,/p/pose/orientation/z",
        lambda t, x, y, h: "{},{},{},{qw},{qx},{qy},{qz}".format(t, x, y, **of_turn(h)),
    ),
    "gaps": (
        "t\tx\ty\troll\tpitch\tyaw",
        lambda t, x, y, h: f"{t}\t{x}\t{y}\t0\t0\t{h!r}\n{t}5\tnan\tnan\tnan\tnan\tnan",
    ),
    "milliseconds": ("timestamp,x,y,yaw", lambda t, x, y, h: f"{1.7e12 + 1e3 * t:.0f},{x},{y},{h!r}"),
    "dots": ("", lambda t, x, y, h: _comma(f"31.01.2026 12:00:{t};{x};{y};{h!r}")),
    "dotted and spaced": ("# made by hand", lambda t, x, y, h: f"31.01.2026 12:00:{t} {x} {y} {h!r}"),
    "ISO": ("stamp,x,y,heading", lambda t, x, y, h: f"2026-01-31T13:00:{t}+01:00,{x},{y},{h!r}"),
    "slashes": ("", lambda t, x, y, h: f"2026/01/31 12:00:{t},{x},{y},{h!r}"),
}


def _comma(text: str) -> str:
    return text.replace(".", ",").replace("31,01,2026", "31.01.2026")


@pytest.mark.parametrize("name", NAMED)
def test_columns_with_names_and_dates_are_read_in_any_order_and_told(name, tmp_path):
    head, row = NAMED[name]
    (tmp_path / "slam.csv").write_text(head + "\n" + "".join(row(*each) + "\n" for each in ROWS))
    found = trajectory_rows(tmp_path / "slam.csv", None)
    start = datetime(2026, 1, 31, 12, tzinfo=UTC).timestamp()
    since = {"rostopic": 1.7e9, "milliseconds": 1.7e9, "dots": start, "ISO": start, "slashes": start}
    begins = since.get(name.replace("dotted and spaced", "dots"), 0.0)
    expected = [(begins + time, *pose) for time, *pose in ROWS]
    np.testing.assert_allclose(found["rows"], expected, atol=1e-6)
    said = found["notes"]["columns of the trajectory"]
    assert said.startswith("kept: time = ")
    assert ", x = " in said


def test_times_without_poses_are_told_and_another_time_than_the_runs_is_refused(tmp_path):
    times = [2.0, *np.arange(3.0, 6.0, 0.1), *np.arange(9.0, 11.0, 0.1)]
    (tmp_path / "slam.tum").write_text("".join(f"{t + 1.7e9} {t} 0 0\n" for t in times))
    run = SimpleNamespace(time=np.arange(0.0, 15.0), metadata={"log start": "1.7e9"})
    notes: dict[str, str] = {}
    assert offset_to_run(tmp_path / "slam.tum", run, notes=notes) == -1.7e9
    assert listed_notes(notes) == [
        "guessed: pose before the first of the trajectory: it stays the same for 2.0 s",
        "guessed: pose after the last of the trajectory: it stays the same for 3.1 s",
        "guessed: poses in gaps of the trajectory: interpolated; the longest gap is 3.1 s, from 5.9 s",
    ]
    with pytest.raises(
        UsageError, match=r"has poses from 1700000002\.000 to .* no pose is at 0\.000 s of the run: give"
    ):
        offset_to_run(tmp_path / "slam.tum", run, offset=0.0, notes=notes)


@pytest.mark.parametrize("unit", [1.0, 180.0 / math.pi])
def test_headings_without_a_unit_are_in_the_one_in_which_the_robot_moves_ahead(unit, tmp_path):
    turns = 0.5 * np.arange(40)  # three turns, not wrapped
    text = "".join(f"{t},{math.sin(h)},{1 - math.cos(h)},{unit * h}\n" for t, h in enumerate(turns.tolist()))
    (tmp_path / "slam.csv").write_text(f"t,x,y,theta\n{text}")
    found = trajectory_rows(tmp_path / "slam.csv", None)
    np.testing.assert_allclose(found["rows"][:, 3], turns, atol=1e-9)
    assert f"guessed: in {'rad' if unit == 1.0 else 'deg'}, as" in found["notes"]["headings of the trajectory"]


@pytest.mark.parametrize("kind", ["PoseStamped", "PoseWithCovarianceStamped"])
def test_poses_of_a_bag_are_read_and_its_topics_named(kind, tmp_path):
    with new_bag(tmp_path / "theirs", "sqlite") as bag:
        for time, x, y, turn in ROWS:
            pose = bag.pose(Pose3(x, y, 0.3, 0.0, 0.0, math.sin(turn / 2), math.cos(turn / 2)))
            header = bag.header(time, "map")
            for topic in ("/slam", "/other"):
                if kind == "PoseStamped":
                    bag.put(topic, time, bag.make("geometry_msgs/PoseStamped", header=header, pose=pose))
                else:
                    inner = bag.make("geometry_msgs/PoseWithCovariance", pose=pose, covariance=np.zeros(36))
                    bag.put(topic, time, bag.make("geometry_msgs/PoseWithCovarianceStamped", header=header, pose=inner))
    (path,) = [each for each in tmp_path.iterdir() if each.name.startswith("theirs")]
    np.testing.assert_allclose(trajectory_rows(path, "/slam")["rows"], ROWS, atol=1e-9)
    with pytest.raises(UsageError, match=r"has 2 topics with poses \(/other, /slam\); name one of them with topic"):
        trajectory_rows(path, None)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "has 0 poses at different times"),
        ("1 2 3 4\n", "has 1 poses at different times"),
        ("1 2 3 4\n1 2 3\n", "track.tum:2: '1 2 3' is not a pose; write t x y z qx qy qz qw, or t x y heading"),
        ("1 2 nan 4\n", "track.tum:1: '1 2 nan 4' is not a pose"),
        ("0 1 1 0 0 0 0 0\n", "track.tum:1: '0 1 1 0 0 0 0 0' has a quaternion of length 0; without headings, write"),
        ("where x y z\n", "track.tum:1: 'where x y z' is not a pose"),
        (
            "time x y z\n1 2 3 4\n",
            "track.tum': no column is heading among 'time', 'x', 'y', 'z'; name the columns time, x",
        ),
        (
            "t,/a/pose/position/x,/b/pose/position/x,y,yaw\n0,1,1,1,0\n",
            "track.tum': 2 columns may be x ('/a/pose/position/x', '/b/pose/position/x'); name the columns time, x, y,",
        ),
        ("31/01/2026 12:00:00,1,2,0\n", "track.tum:1: '31/01/2026 12:00:00,1,2,0' is not a pose; write t x y z"),
        ("t,x,y,yaw\n0,0,0,0\n1,0,1,180\n", "yaw goes to 180 without a unit; name it heading_deg or heading_rad"),
        ("t,x,y,yaw\nnan,0,0,0\n", "holds no row with values of t, x, y, yaw"),
    ],
)
def test_a_file_that_is_no_trajectory_is_refused_in_one_line(text, says, tmp_path):
    (tmp_path / "track.tum").write_text(text)
    with pytest.raises(UsageError) as caught:
        read_trajectory(tmp_path / "track.tum")
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


WORLD = """mjsim: 1
name: room
walls: [{points: [[0, 0], [5, 0], [5, 4], [0, 4]], closed: true}]
robots: [{name: scout, preset: pioneer3dx, at: [1, 1], heading_deg: 30}]
run:
  seconds: 1.5
  rate_hz: 25
  drivers: {scout: {navigator: {use: "mjsim.algorithms.waypoints:Waypoints", points: [[3, 1], [3, 3]]}}}
"""


@pytest.mark.slow
def test_somebody_elses_slam_is_judged_on_our_truth(tmp_path, capsys):
    with Simulation(parse_world(WORLD), seed=1) as simulation:
        export_tum(run(simulation, record=tmp_path / "run.mcap"), tmp_path)
    truth = np.loadtxt(tmp_path / "scout_truth.tum")
    theirs = Pose(3.0, -2.0, 1.1)  # their map has a frame of its own, and their clock another start
    lines = []
    for time, x, y, _, _, _, qz, qw in truth.tolist():
        pose = theirs @ Pose(x, y, 2.0 * math.atan2(qz, qw))
        lines.append(f"{time + 100.0} {pose.x} {pose.y} 0 {quaternion(pose.heading)}\n")
    (tmp_path / "slam.tum").write_text("".join(lines[::3]))
    spec = f"mjsim.logs.trajectory:Trajectory{{file: {tmp_path}/slam.tum, offset: -100}}"
    recording = str(tmp_path / "run.mcap")
    replay = ("replay", recording, "--robot", "scout", "-o", str(tmp_path / "theirs.mcap"))
    assert run_command(*replay, "--trajectory", str(tmp_path / "slam.tum")) == 2
    refused = capsys.readouterr().err
    assert "no pose is at 0.000 s of the run: give another offset" in refused
    assert run_command(*replay, "--estimator", spec.replace(", offset: -100", "")) == 2
    assert capsys.readouterr().err == refused
    assert run_command(*replay, "--estimator", spec, "--overwrite") == 0
    assert run_command("report", str(tmp_path / "theirs.mcap"), "-o", str(tmp_path / "page")) == 0
    figures = json.loads((Path(tmp_path) / "page" / "statistics.json").read_text())["robots"]["scout"]
    assert figures["position_error_m"]["rmse"] < 0.005
    assert figures["ate_m"]["rmse"] < 0.005


def test_the_first_pose_is_where_the_robot_starts_unless_the_frame_is_the_worlds(tmp_path):
    (tmp_path / "track.tum").write_text("".join(f"{t} {x} {y} {turn!r}\n" for t, x, y, turn in ROWS))
    with pytest.raises(ValueError, match="frame is 'map'; it must be start or world"):
        Trajectory(str(tmp_path / "track.tum"), frame="map")
    robot, first, last = (
        SimpleNamespace(**each) for each in ({"prior": Pose(7, 7, 0.0)}, {"time": 10.5}, {"time": 13})
    )
    for frame, begins in (("start", Pose(7.0, 7.0, 0.0)), ("world", Pose(1.5, 2.0, math.pi))):
        theirs = Trajectory(str(tmp_path / "track.tum"), frame=frame)
        theirs.start(robot, {}, np.random.default_rng())
        found = theirs.update(first).pose
        assert (found.x, found.y) == pytest.approx((begins.x, begins.y))
        assert math.cos(found.heading - begins.heading) == pytest.approx(1.0)
        end = theirs.update(last).pose  # the last one stays
        assert math.hypot(end.x - found.x, end.y - found.y) == pytest.approx(math.hypot(0.5, 2.0))


def test_a_ground_truth_of_euroc_is_read(tmp_path):
    rows = []
    for time, x, y, turn in ROWS:
        _, _, z, w = (float(word) for word in quaternion(turn).split())
        rows.append(f"{1_403_715_000_000_000_000 + round(1e9 * time)},{x},{y},0.9,{w!r},0,0,{z!r},0.1,0,0,0,0,0,0,0,0")
    (tmp_path / "data.csv").write_text("#timestamp, p_RS_R_x [m], ...\n" + "\n".join(rows))
    expected = [(1_403_715_000.0 + time, *pose) for time, *pose in ROWS]
    np.testing.assert_allclose(read_trajectory(tmp_path / "data.csv"), expected, rtol=0.0, atol=1e-6)


@pytest.mark.slow
def test_a_trajectory_is_told_from_a_log_by_its_rows(tmp_path):
    tum = f"# poses\n1.5 0 0 0 {quaternion(0.3)}\n"
    for text in (tum, "1 0 0 0 0 1 0 0 0 0 1 0\n", "1403715524907143168,0.5,1.9,0.9,1,0,0,0\n"):
        (tmp_path / "theirs.txt").write_text(text)
        with pytest.raises(UsageError, match=r"is a trajectory, not a log; evaluate it with mjsim replay RUN\.mcap"):
            import_log(tmp_path / "theirs.txt", record=tmp_path / "out.mcap")
    (tmp_path / "theirs.txt").write_text("1 2 3 4 5 6 7 8\n")
    with pytest.raises(UsageError, match="is not a supported log"):
        import_log(tmp_path / "theirs.txt", record=tmp_path / "out.mcap")


@pytest.mark.slow
def test_a_bag_of_poses_alone_is_told_to_be_a_trajectory(tmp_path):
    with new_bag(tmp_path / "theirs", "sqlite") as bag:
        pose = bag.pose(Pose3(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0))
        for time in (1.0, 2.0):
            bag.put("/slam", time, bag.make("geometry_msgs/PoseStamped", header=bag.header(time, "map"), pose=pose))
    with pytest.raises(UsageError, match=r"evaluate its poses with mjsim replay RUN\.mcap --trajectory"):
        import_log(tmp_path / "theirs", record=tmp_path / "out.mcap")


def test_a_topic_of_a_file_that_is_no_bag_is_refused(tmp_path):
    (tmp_path / "track.tum").write_text(f"1 0 0 0 {quaternion(0.0)}\n2 1 0 0 {quaternion(0.0)}\n")
    with pytest.raises(UsageError, match="is not a ROS bag, so it has no topics; leave out topic"):
        trajectory_rows(tmp_path / "track.tum", "/slam")
