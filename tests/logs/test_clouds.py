"""Clouds of ROS as bytes: fields in any order and type, times of any kind, frames of any robot."""

from types import SimpleNamespace as Message

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mjsim.logs.bags.bag_clouds import MAX_TURN, cloud_of, end_of, units_of

NUMBERS = {"i1": 1, "u1": 2, "i2": 3, "u2": 4, "i4": 5, "u4": 6, "f4": 7, "f8": 8}
POINTS = np.array([[1.0, 2.0, 3.0], [0.0, 0.0, 0.0], [4.0, -5.0, 6.0], [np.nan, 1.0, 1.0], [7.0, 8.0, 9.0]])
TURNED = np.eye(4)
TURNED[:3, :3], TURNED[:3, 3] = Rotation.from_euler("z", 90, degrees=True).as_matrix(), [9.0, 9.0, 9.0]


def message(columns, *, big=False, height=1, gap=0, tail=0, stamp=100.0):
    """Return a cloud whose points have a gap after their fields, and rows a tail [bytes]."""
    order = ">" if big else "<"
    kinds = [(name, order + kind) for name, (kind, _) in columns.items()]
    plain = np.dtype(kinds)
    dtype = np.dtype(
        {
            "names": plain.names,
            "formats": [k for _, k in kinds],
            "offsets": [plain.fields[n][1] for n in plain.names],
            "itemsize": plain.itemsize + gap,
        }
    )
    count = len(next(iter(columns.values()))[1])
    rows = np.zeros(count, dtype)
    for name, (_, values) in columns.items():
        rows[name] = values
    width = count // height
    data = b"".join(rows[k * width : (k + 1) * width].tobytes() + bytes(tail) for k in range(height))
    fields = [Message(name=n, offset=dtype.fields[n][1], datatype=NUMBERS[k[1:]], count=1) for n, k in kinds]
    fields.append(Message(name="odd", offset=0, datatype=99, count=1))
    return Message(
        header=Message(stamp=Message(sec=int(stamp), nanosec=int(stamp % 1 * 1e9))),
        fields=fields,
        is_bigendian=big,
        point_step=dtype.itemsize,
        row_step=dtype.itemsize * width + tail,
        width=width,
        height=height,
        data=np.frombuffer(data, np.uint8),
    )


def xyz(kind="f4", points=POINTS):
    return {axis: (kind, points[:, k]) for k, axis in enumerate("xyz")}


@pytest.mark.parametrize(("big", "kind", "height", "gap", "tail"), [(False, "f4", 1, 0, 0), (True, "f8", 5, 3, 7)])
def test_points_that_came_back_are_turned_to_the_axes_of_the_robot(big, kind, height, gap, tail):
    more = {"intensity": ("u2", [10, 20, 30, 40, 50]), "ring": ("u1", [0, 1, 2, 3, 4])}
    cloud = cloud_of(
        message({**more, **xyz(kind)}, big=big, height=height, gap=gap, tail=tail), 3.0, robot_from_sensor=TURNED
    )
    np.testing.assert_allclose(cloud.points, [[-2.0, 1.0, 3.0], [5.0, 4.0, 6.0], [-8.0, 7.0, 9.0]], atol=1e-6)
    np.testing.assert_array_equal(cloud.intensities, [10, 30, 50])
    np.testing.assert_array_equal(cloud.rings, [0, 2, 4])
    np.testing.assert_array_equal(cloud.times, 0.0)
    assert cloud.stamp == 3.0


@pytest.mark.parametrize(
    ("kind", "values"),
    [
        ("f4", np.arange(5) * 0.02),
        ("u4", np.arange(5) * 20_000_000),
        ("f8", 100.0 + np.arange(5) * 0.02 + 1.7e9),
        ("f8", (100.0 + np.arange(5) * 0.02 + 1.7e9) * 1e9),
    ],
)
def test_times_of_points_are_seconds_or_nanoseconds_since_the_stamp_or_since_1970(kind, values):
    stamp = 100.0 + (1.7e9 if values.max() > 1e9 else 0.0)
    told = message({**xyz(), "t": (kind, values)}, stamp=stamp)
    assert end_of(told) == pytest.approx(0.08, abs=1e-5)
    np.testing.assert_allclose(cloud_of(told, 0.0, robot_from_sensor=TURNED).times, [-0.08, -0.04, 0.0], atol=1e-5)


@pytest.mark.parametrize("values", [np.arange(5) * MAX_TURN, [0.0, np.nan, 0.1, 0.2, 0.3], np.full(5, 50.0)])
def test_numbers_that_are_no_times_of_a_turn_are_left_out(values):
    told = message({**xyz(), "time": ("f8", values)})
    assert end_of(told) == 0.0
    np.testing.assert_array_equal(cloud_of(told, 0.0, robot_from_sensor=TURNED).times, 0.0)


def test_intensities_that_are_no_numbers_are_zero_and_rings_within_their_range():
    told = message({**xyz(), "i": ("f4", [np.nan, 1, np.inf, 1, 5]), "line": ("i4", [-3, 0, 70_000, 0, 2])})
    cloud = cloud_of(told, 0.0, robot_from_sensor=TURNED)
    np.testing.assert_array_equal(cloud.intensities, [0.0, 0.0, 5.0])
    np.testing.assert_array_equal(cloud.rings, [0, 65535, 2])


def test_data_that_do_not_match_their_fields_are_refused():
    with pytest.raises(ValueError, match="a cloud of fields x, y; it needs x, y and z"):
        cloud_of(message({"x": ("f4", [1.0]), "y": ("f4", [1.0])}), 0.0, robot_from_sensor=TURNED)
    for change in ({"point_step": 11}, {"row_step": 40}, {"height": 2}):
        told = message(xyz())
        vars(told).update(change)
        with pytest.raises(ValueError, match=r"a cloud of 5 x \d points of \d+ bytes"):
            cloud_of(told, 0.0, robot_from_sensor=TURNED)


def turns(kind, span, *, period=0.1, start=100.0, points=None):
    """Return clouds whose points were measured over a span, in the unit of the file."""
    points = np.random.default_rng(0).uniform(1.0, 2.0, (50, 3)) if points is None else points
    times = np.linspace(0.0, span, len(points))
    return [message({**xyz(points=points), "t": (kind, times)}, stamp=start + k * period) for k in range(4)]


@pytest.mark.parametrize(
    ("kind", "span", "period", "unit", "note"),
    [
        ("u4", 99_000_000, 0.1, 1e-9, ""),
        ("f4", 0.099, 0.1, 1.0, ""),
        ("u4", 4_000_000, 0.1, 1e-9, ""),
        ("u4", 99_000, 0.1, 1e-6, "guessed: 't' in us, so that a scan lasts 0.099 s, and the next comes after 0.1 s"),
        (
            "f4",
            49_000.0,
            0.05,
            1e-6,
            "guessed: 't' in us, so that a scan lasts 0.049 s, and the next comes after 0.05 s",
        ),
        ("f4", 99.0, 0.1, 1e-3, "guessed: 't' in ms, so that a scan lasts 0.099 s, and the next comes after 0.1 s"),
        ("u2", 99, 0.1, 1e-3, "guessed: 't' in ms, so that a scan lasts 0.099 s, and the next comes after 0.1 s"),
        ("f4", 2.5, 0.1, 1.0, "guessed: in s, though 't' goes from 0 to 2.5; clouds come every 0.1 s"),
        ("u4", 4000, 60.0, 1e-9, "guessed: in ns, though 't' goes from 0 to 4000; clouds come every 60 s"),
        ("f4", 4e8, 0.1, 0.0, "left out: 't' goes from 0 to 4e+08; clouds come every 0.1 s; all points have one time"),
    ],
)
def test_a_scan_lasts_about_as_long_as_the_time_to_the_next_one(kind, span, period, unit, note):
    clouds = turns(kind, span, period=period)
    units = units_of(clouds)
    assert dict(units.notes).get("times", "") == note
    times = cloud_of(clouds[0], 0.0, robot_from_sensor=TURNED, units=units).times
    np.testing.assert_allclose(
        times, unit * np.linspace(-span, 0.0, 50), rtol=1e-5, atol=unit if kind[0] == "u" else 1e-8
    )


def test_times_on_the_clock_of_a_simulation_are_relative_to_the_stamp():
    told = message({**xyz(), "timestamp": ("f8", 41.5 + np.arange(5) * 0.02)}, stamp=41.5)
    np.testing.assert_allclose(cloud_of(told, 0.0, robot_from_sensor=TURNED).times, [-0.08, -0.04, 0.0], atol=1e-5)
    assert units_of([told]).notes == ()


def test_coordinates_are_in_the_unit_that_makes_a_room():
    room = np.random.default_rng(1).uniform(1.0, 6.0, (200, 3))
    for kind, scale, unit in (
        ("f4", 1.0, 1.0),
        ("i2", 1e3, 1e-3),
        ("i4", 1e3, 1e-3),
        ("f4", 1e3, 1e-3),
        ("i2", 10.0, 1.0),
    ):
        told = message(xyz(kind, room * scale))
        units = units_of([told])
        assert units.length == unit
        assert ("coordinates" in dict(units.notes)) == (kind != "f4" or scale != 1.0)
        points = cloud_of(told, 0.0, robot_from_sensor=np.eye(4), units=units).points
        np.testing.assert_allclose(points, room * scale * unit, atol=unit + 1e-6)


def test_clouds_without_points_or_times_have_the_units_of_ros():
    nothing = message(xyz(points=np.zeros((0, 3))))
    damaged = message(xyz())
    damaged.point_step = 3
    for clouds in ([], [nothing], [damaged], [message(xyz())], turns("f4", 0.0)):
        assert units_of(clouds) == units_of([])
