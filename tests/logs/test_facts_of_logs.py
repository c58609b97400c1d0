"""Small facts of the readers of logs, each computed another way."""

import math
import struct
from types import SimpleNamespace as Message

import numpy as np
import pytest

from mjsim.errors import UsageError
from mjsim.geometry import Pose3
from mjsim.logs.bags.bag_clocks import Clocks
from mjsim.logs.bags.bag_frames import FrameTree, is_base, is_odometry, level_mount, matrix_of, mount_of
from mjsim.logs.bags.bag_messages import imu_of, is_clockwise, limits_of, scan_of
from mjsim.logs.bags.bag_order import FileOrder, InFileOrder, going_on, set_backs
from mjsim.logs.calibration import _motion
from mjsim.logs.files.csv_table import headings_in
from mjsim.logs.formats.description import Description


def laser(ranges: list[float], **keys: object) -> Message:
    about = {"angle_min": -0.2, "angle_max": 0.2, "angle_increment": 0.1, "range_min": 0.1, "range_max": 30.0}
    return Message(**{**about, "ranges": np.array(ranges), "intensities": [], **keys})


def test_a_scan_goes_from_right_to_left_however_its_lidar_turns_and_hangs():
    ranges = [1.0, 2.0, 3.0, 4.0]
    plain = scan_of(laser(ranges, intensities=[1, 2, 3, np.nan]), 5.0, upside_down=False)
    assert (plain.stamp, plain.angle_min, plain.angle_increment) == (5.0, -0.2, 0.1)
    assert (plain.ranges.tolist(), plain.intensities.tolist()) == (ranges, [1, 2, 3, 0])
    back = scan_of(laser(ranges, angle_min=0.2, angle_increment=-0.1, intensities=[1, 2, 3, 4]), 5.0, upside_down=False)
    assert (back.ranges.tolist(), back.intensities.tolist()) == (ranges[::-1], [4, 3, 2, 1])
    assert (back.angle_min, back.angle_increment) == (pytest.approx(-0.1), pytest.approx(0.1))
    hung = scan_of(laser(ranges), 5.0, upside_down=True)
    assert (hung.ranges.tolist(), hung.angle_min, hung.angle_increment) == (ranges[::-1], pytest.approx(-0.1), 0.1)
    assert hung.intensities is None
    assert [
        is_clockwise(laser(ranges, angle_increment=step), upside_down=down) for step in (0.1, -0.1) for down in (0, 1)
    ] == [
        False,
        True,
        True,
        False,
    ]
    # Without an increment, the ends tell it.
    spread = scan_of(laser([1.0] * 5, angle_increment=0.0), 5.0, upside_down=False)
    assert spread.angle_increment == pytest.approx(0.1)


def test_ranges_out_of_limits_are_infinite():
    scan = scan_of(laser([0.05, 0.1, np.nan, 29.9, 30.0, np.inf]), 0.0, upside_down=False)
    assert scan.ranges.tolist() == [-np.inf, 0.1, -np.inf, 29.9, np.inf, np.inf]
    echoes = laser([0.0] * 2)
    echoes.ranges = [Message(echoes=[2.0, 9.0]), Message(echoes=[])]
    assert scan_of(echoes, 0.0, upside_down=False).ranges.tolist() == [2.0, np.inf]


@pytest.mark.parametrize("beams", [2, 3, 7, 13])
def test_a_scan_of_another_number_of_beams_covers_the_same_angle(beams):
    ranges = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]
    scan = scan_of(laser(ranges, intensities=ranges), 0.0, upside_down=False, beams=beams)
    assert len(scan.ranges) == len(scan.intensities) == beams
    assert scan.angle_min + scan.angle_increment * (beams - 1) == pytest.approx(0.4)
    angles = scan.angle_min + scan.angle_increment * np.arange(beams)
    assert np.abs(scan.ranges - (1.0 + (angles + 0.2) / 0.1)).max() <= 0.5 + 1e-9
    assert scan.ranges.tolist() == scan.intensities.tolist()


@pytest.mark.parametrize(
    "keys",
    [
        {"count": 1},
        {"angle_min": np.nan},
        {"angle_increment": 4.0},
        {"angle_increment": 0.0, "angle_max": -0.2},
        {"angle_increment": 3.14, "count": 9},
    ],
)
def test_scans_without_angles_are_refused(keys):
    keys = dict(keys)
    count = keys.pop("count", 3)
    with pytest.raises(ValueError, match=r"a scan (of|over)"):
        scan_of(laser([1.0] * count, **keys), 0.0, upside_down=False)


@pytest.mark.parametrize(
    ("given", "found"),
    [
        ((0.1, 30.0), (0.1, 30.0)),
        ((0.0, 30.0), (0.01, 30.0)),
        ((np.nan, 0.0), (0.01, 100.0)),
        ((0.1, np.inf), (0.1, 100.0)),
        ((60.0, 50.0), (60.0, 120.0)),
        ((0.1, 1e4), (0.1, 1e4)),
    ],
)
def test_limits_of_a_lidar_that_makes_no_sense_of_them_are_assumed(given, found):
    assert limits_of(laser([], range_min=given[0], range_max=given[1])) == found


@pytest.mark.parametrize("order", ["<", ">", "ros1"])
@pytest.mark.parametrize("frame", ["imu", "imu_link", ""])
def test_an_inertial_reading_is_decoded_where_its_numbers_begin(order, frame):
    sign = "<" if order == "ros1" else order
    name = frame.encode() + (b"" if order == "ros1" else b"\0")
    head = struct.pack(f"{sign}3I", *(7, 1, 2) if order == "ros1" else (0, 0, 0))
    # Four bytes of encapsulation stand before a body of CDR, in which 8-byte numbers are aligned.
    body = struct.pack(f"{sign}2I", 1, 2) + struct.pack(f"{sign}I", len(name)) + name
    if order == "ros1":
        data = head + struct.pack("<I", len(name)) + name
    else:
        data = bytes([0, order == "<", 0, 0]) + body + bytes(-len(body) % 8)
    numbers = [float(k) for k in range(37)]
    whole = data + struct.pack(f"{sign}37d", *numbers)
    found = imu_of(whole, is_ros2=order != "ros1")
    assert found == (25.0, 26.0, 27.0, 13.0, 14.0, 15.0)
    with pytest.raises(ValueError, match="a truncated inertial reading"):
        imu_of(whole[:-1], is_ros2=order != "ros1")
    for place, missing in ((16, slice(3, 6)), (28, slice(0, 3))):
        unknown = [*numbers[:place], -1.0, *numbers[place + 1 :]]
        values = imu_of(data + struct.pack(f"{sign}37d", *unknown), is_ros2=order != "ros1")
        assert np.isnan(values[missing]).all()
        assert np.isfinite(values).sum() == 3
    with pytest.raises(ValueError, match="not a number"):
        imu_of(data + struct.pack(f"{sign}37d", *numbers[:25], math.inf, *numbers[26:]), is_ros2=order != "ros1")


def test_stamps_of_messages_without_headers_are_interpolated():
    clocks, recorded = Clocks(), np.array([100.0, 101.0, 102.5])
    assert clocks.stamps_at(recorded).tolist() == recorded.tolist()
    for time in (104.0, 100.0, 102.0):
        clocks.time("/odom", time, time - 90.0)
    clocks.time("/other", 100.0, 100.0)
    assert clocks.stamps_at(recorded) == pytest.approx([10.0, 11.0, 12.5])
    near = Clocks()
    for time in (100.0, 104.0):
        near.time("/odom", time, time - 0.5)
    assert near.stamps_at(recorded).tolist() == recorded.tolist()


def test_a_recorder_that_was_set_back_is_noted():
    assert Clocks([(5.0, 2.0), (7.0, 0.5)]).settle() == {
        "clock of the recorder": "mended: set back 2 times (-2.00 s, -0.50 s); times continue from there"
    }
    assert Clocks().settle() == {}


@pytest.mark.parametrize(
    ("outer", "inner", "odometry"),
    [
        ("odom", "base_link", True),
        ("robot/odom", "robot/base", True),
        ("wheel_odometry", "x", True),
        ("map", "odom", False),
        ("odom", "map", False),
        ("odom", "odom_combined", False),
        ("odom", "world", False),
        ("map", "base_link", False),
    ],
)
def test_odometry_is_known_by_its_frames(outer, inner, odometry):
    assert is_odometry(outer, inner) == odometry
    assert [is_base(name) for name in ("r/base_link", "base_footprint", "laser")] == [True, True, False]


def transform(outer: str, inner: str, x: float, yaw: float) -> Message:
    turn = Message(x=0.0, y=0.0, z=math.sin(yaw / 2), w=math.cos(yaw / 2))
    place = Message(translation=Message(x=x, y=0.0, z=0.0), rotation=turn)
    return Message(header=Message(frame_id=outer), child_frame_id=inner, transform=place)


def test_frames_are_connected_in_both_directions():
    tree = FrameTree()
    tree.add([transform("/base_link", "mast", 1.0, math.pi / 2)], fixed=True)
    tree.add([transform("mast", "laser", 2.0, 0.0)], fixed=True)
    place = tree.between("base_link", "laser")
    assert place[:3, 3] == pytest.approx([1.0, 2.0, 0.0])
    assert (mount_of(place).at, mount_of(place).yaw) == (pytest.approx((1.0, 2.0, 0.0)), pytest.approx(math.pi / 2))
    assert (level_mount(place).at, level_mount(place).yaw) == (pytest.approx((1.0, 2.0, 0.0)), 0.0)
    assert tree.between("laser", "base_link") == pytest.approx(np.linalg.inv(place))
    assert (tree.between("laser", "none"), "mast" in tree, "none" in tree) == (None, True, False)
    assert (tree.base(""), tree.base("r"), FrameTree().base("")) == ("base_link", "base_link", None)
    # A fixed frame is corrected; of a moving one the first pose counts.
    for fixed, x in ((False, 2.0), (True, 5.0)):
        tree.add([transform("mast", "laser", 5.0, 0.0)], fixed=fixed)
        assert tree.between("mast", "laser")[0, 3] == pytest.approx(x)
    other = FrameTree()
    other.add([transform("mast", "laser", 9.0, 0.0), transform("mast", "eye", 3.0, 0.0)], fixed=True)
    both = tree.joined(other)
    assert [both.between("mast", name)[0, 3] for name in ("laser", "eye")] == pytest.approx([5.0, 3.0])


@pytest.mark.parametrize(("x", "q"), [(1e9, 1.0), (np.nan, 1.0), (0.0, 0.4), (0.0, 2.5), (0.0, np.nan)])
def test_poses_that_are_none_are_refused(x, q):
    with pytest.raises(ValueError, match="a pose of numbers"):
        matrix_of(Message(x=x, y=0.0, z=0.0), Message(x=0.0, y=0.0, z=0.0, w=q))
    long = matrix_of(Message(x=1.0, y=0.0, z=0.0), Message(x=0.0, y=0.0, z=0.9, w=0.9))
    assert long == pytest.approx(Pose3(1.0, 0.0, 0.0, 0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5)).matrix())


def test_a_recorder_set_back_reads_on_in_the_order_of_the_file():
    rows = np.arange(40)
    times = np.where(rows < 20, rows, rows - 15) * 10**8
    topics = np.where(rows % 2, "/a", "/b")
    assert set_backs(rows % 2, times * 1e-9) == [(20, pytest.approx(1.5))]

    def read():
        yield from ((topic, int(time), b"%d" % row) for topic, time, row in zip(topics, times, rows, strict=True))

    links = [Message(topic="/a"), Message(topic="/b")]
    order = FileOrder(topics.tolist(), times, read)
    closed = []
    whole = InFileOrder(
        Message(connections=links, close=lambda: closed.append(1)),
        [order],
        np.array([20]),
        np.array([0, 1_500_000_000]),
    )
    found = list(whole.messages(links))
    assert [time for _, time, _ in found] == (rows * 10**8).tolist()
    assert [data for *_, data in found] == [b"%d" % row for row in rows]
    late = list(whole.messages(links[:1], start=25 * 10**8))
    assert [(link.topic, time) for link, time, _ in late] == [("/a", k * 10**8) for k in range(25, 40, 2)]
    whole.close()
    assert closed == [1]
    unknown = Message()
    assert going_on(unknown, [Message()]) == (unknown, [])


class Table:
    path, lines = "t.csv", [7, 8]

    def __init__(self, *columns: list[float]) -> None:
        self._columns = dict(zip("xyzw", map(np.array, columns), strict=True))

    def column(self, name: str) -> np.ndarray:
        return self._columns[name]


def test_headings_of_quaternions_are_those_of_their_matrices():
    rng = np.random.default_rng(1)
    turns = rng.normal(size=(2, 4))
    turns /= np.linalg.norm(turns, axis=1)[:, None]
    expected = [math.atan2(m[1, 0], m[0, 0]) for m in (Pose3(0, 0, 0, *q).matrix() for q in turns.tolist())]
    assert headings_in(Table(*turns.T), "xyzw") == pytest.approx(expected)
    with pytest.raises(UsageError, match=r"t.csv:8: the quaternion has length 1.1, not 1"):
        headings_in(Table(*(turns * [[1.0], [1.1]]).T), "xyzw")


POSES = {"file": "a.csv", "time": 1, "x": "x", "y": "y"}
SCANS = {"file": "a.csv", "time": 1, "ranges": "r", "from_deg": -90, "step_deg": 1, "range": [0.1, 8]}
SEEN = {"file": "a.csv", "time": 1, "range": "r"}


@pytest.mark.parametrize(
    ("keys", "good"),
    [
        ({"odometry": {**POSES, "heading": 4}}, True),
        ({"odometry": {**POSES, "heading_deg": 4}}, True),
        ({"odometry": {**POSES, "quaternion": [1, 2, 3, 4]}}, True),
        ({"odometry": POSES}, False),
        ({"odometry": {**POSES, "heading": 4, "heading_deg": 5}}, False),
        ({"odometry": {**POSES, "heading": 0}}, False),
        ({"odometry": {**POSES, "heading": ""}}, False),
        ({"odometry": {**POSES, "heading": "h" * 200}}, True),
        ({"odometry": {**POSES, "heading": "h" * 201}}, False),
        ({"twist": {"file": "a", "time": 1, "forward": 2, "turn": 3}}, True),
        ({"twist": {"file": "a", "time": 1, "forward": 2}}, False),
        ({"sightings": {**SEEN, "bearing_deg": 3}}, True),
        ({"sightings": SEEN}, False),
        ({"scans": [SCANS]}, True),
        ({"scans": [{**SCANS, "range": [8, 0.1]}]}, False),
        ({"scans": [{**SCANS, "range": [8, 8]}]}, False),
        ({"scans": [{**SCANS, "step_deg": 0}]}, False),
    ],
)
def test_a_description_names_one_angle_and_real_columns(keys, good):
    if good:
        Description.model_validate({"log": "tables", **keys})
    else:
        with pytest.raises(ValueError, match=r"name one of|there is no column|a column name of|range|step"):
            Description.model_validate({"log": "tables", **keys})


def test_the_mount_of_a_lidar_is_in_radians():
    about = Description.model_validate({"log": "tables", "scans": [{**SCANS, "yaw_deg": 90, "at": [0.1, 0.2, 0.3]}]})
    mount = about.scans[0].mount()
    assert (mount.at, mount.yaw) == ((0.1, 0.2, 0.3), pytest.approx(math.pi / 2))


@pytest.mark.parametrize(("period", "swings"), [(0.04, True), (2.0, False)])
def test_noise_of_odometry_grows_with_all_that_a_robot_drives_and_turns_in_a_window(period, swings):
    # In 2 s it drives 1 m, and turns by 0.5 rad to and fro each half second, or steadily; 600 windows.
    rng, ticks = np.random.default_rng(4), round(1200 / period)
    time, a, b = period * np.arange(ticks + 1), 0.02, 0.03
    turned = 0.5 * np.abs((2.0 * time) % 2.0 - 1.0) if swings else 0.25 * time
    truth = np.column_stack([0.5 * time, 0.0 * time, turned])
    by = np.hypot(*np.diff(truth[:, :2], axis=0).T), np.abs(np.diff(truth[:, 2]))
    errors = [scale * np.cumsum(np.sqrt(each) * rng.normal(size=ticks)) for scale, each in zip((a, b), by, strict=True)]
    odometry = truth + np.pad(np.column_stack([errors[0], 0.0 * errors[0], errors[1]]), [(1, 0), (0, 0)])
    odometry[:, 0] *= 1.05
    found = _motion(Message(time=time, truth=truth, odometry=odometry))
    # Of 600 windows a deviation is known to 3 %.
    assert (found.windows, found.scale) == (600, pytest.approx(1.05, abs=0.003))
    assert (found.distance, found.turn) == (pytest.approx(a, rel=0.12), pytest.approx(b, rel=0.12))
    assert found.turn_bias == pytest.approx(0.0, abs=0.002)
