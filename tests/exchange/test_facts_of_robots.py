"""Figures of robots from files, computed another way: presets, steering, forward directions, slip of drives."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from ruamel.yaml import YAML

from mjsim.errors import UsageError
from mjsim.exchange import RobotOptions
from mjsim.exchange.robots import import_robot, slip
from mjsim.exchange.robots.driven_wheels import Gear, find_gear
from mjsim.exchange.robots.found_wheels import FoundWheel
from mjsim.exchange.robots.mounts import SensorMount
from mjsim.exchange.robots.preset import (
    first_plan,
    max_speed,
    max_steer_deg,
    preset_text,
    preset_turn,
    speed_source,
    wheelbase_of,
    wheels_by_name,
)
from mjsim.exchange.robots.robot_frame import Stand, find_stand
from mjsim.exchange.robots.steering import steering_limit
from mjsim.models import FileJoint, anatomy_of, gather_robot
from mjsim.world import Slip
from tests.exchange.odd_robots import on_casters, on_three, rover, tricycle


def found(text: str, **options: object) -> tuple[Gear, Stand]:
    """Return gear and stand of a robot's file."""
    anatomy = anatomy_of(gather_robot("r.urdf", lambda _: text.encode()))
    gear = find_gear(anatomy, RobotOptions(**options), file="r.urdf", urdf=True)
    return gear, find_stand(anatomy, gear, acceleration=1.0)


def wheel(
    x: float, y: float, *, radius: float = 0.1, steer: tuple[float, float] | None = None, speed: float | None = None
) -> FoundWheel:
    at, axle, up = np.array([x, y, radius]), np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])
    joint = FileJoint(f"w{x:g}{y:g}", 1, False, at, axle, None, True, speed)
    turned = None if steer is None else FileJoint(f"s{y:g}", 1, False, at, up, steer, True)
    return FoundWheel(joint, at, axle, radius, 0.05, turned)


def gear(
    drive: str, rows: list[float], *, track: float = 0.4, single: tuple[FoundWheel, ...] = (), **keys: object
) -> Gear:
    """Return axles at some x, the first of which has the keys."""
    axles = [
        ((wheel(x, track / 2, **(keys if not k else {})),), (wheel(x, -track / 2, **(keys if not k else {})),))
        for k, x in enumerate(rows)
    ]
    return Gear(drive, tuple(axles), (), 0.0, np.array([1.0, 0.0]), (), single)


STAND = Stand(np.zeros(3), 0.0, ((0.2, 0.0, 0.03),), 0.3004, 0.25, np.zeros(3), ())


def preset(gear: Gear, stand: Stand = STAND, **more: object) -> dict:
    plan = first_plan("r", "r.urdf", gear, stand, more.pop("mounts", ()))
    text = preset_text(plan, ["one", "two"])
    assert text.startswith("# one\n# two\nmjsim: 1\n")
    (robot,) = (loaded := YAML(typ="safe").load(text))["robots"]
    return robot | {"run": loaded["run"]}


@pytest.mark.parametrize(
    ("gear", "sizes"),
    [
        (gear("differential", [0.0]), {"track": 0.4}),
        (gear("skid_steer", [0.2, -0.1]), {"track": 0.4, "wheelbase": 0.3, "effective_track": 0.4 + 0.3**2 / 0.4}),
        (gear("mecanum", [0.2, -0.1]), {"track": 0.4, "wheelbase": 0.3, "strafe": 1.0, "spin": 1.0, "max_left": 1.25}),
        (
            gear("ackermann", [0.3, -0.1], steer=(-0.5, 0.6)),
            {
                "track": 0.4,
                "wheelbase": 0.4,
                # Turning about a point on the rear axle, the inner wheel at 0.95 of its limit.
                "max_steer_deg": round(math.degrees(math.atan(0.4 / (0.4 / math.tan(0.475) + 0.2))), 1),
            },
        ),
        (
            gear("tricycle", [-0.1], single=(wheel(0.4, 0.0, steer=(-1.0, 1.2)),)),
            {
                "load_wheel_radius": 0.1,
                "track": 0.4,
                "wheelbase": 0.5,
                "driven": "front",
                "max_steer_deg": round(math.degrees(1.0), 1),
            },
        ),
        (
            gear("omni3", [], single=(wheel(0.3, 0.0), wheel(0.0, 0.3), wheel(0.0, -0.36))),
            {"wheel_circle": 0.32, "strafe": 1.0, "spin": 1.0, "max_left": 1.25},
        ),
    ],
)
def test_a_preset_has_the_sizes_of_its_drive(gear, sizes):
    keys = preset(gear)["drive"]
    common = {"type": gear.drive, "wheel_radius": 0.1, "max_speed": 1.25, "max_acceleration": 1.0}
    assert {key: keys[key] for key in common | sizes} == {
        key: pytest.approx(value) if isinstance(value, float) else value for key, value in (common | sizes).items()
    }
    assert set(keys) == {*common, *sizes, "max_turn_deg", "noise"}


def test_a_preset_has_the_body_of_its_stand():
    stand = Stand(np.array([0.1, 0.0, -0.05]), math.pi / 2, ((0.2, 0.0, 0.03),), 0.3004, 0.2504, np.zeros(3), ())
    mount = SensorMount("lidar", "scan", (0.1, 0.0, 0.2), 90.0, -5.0, {"beams": 181}, "its file")
    robot = preset(gear("differential", [0.0]), stand, mounts=[mount])
    body = robot["body"]
    assert (body["origin"], body["forward_deg"], body["radius"]) == ([0.1, 0, -0.05], 90, 0.301)
    assert (body["height"], body["casters"]) == (0.25, [[0.2, 0, 0.03]])
    assert set(body["wheels"]) == {"left", "right"}
    # Turned by 90 degrees, the left wheel at y = 0.2 of the file lies at x; its y is minus its x there.
    assert body["wheels"]["left"] == {"joint": "w00.2", "y": 0.1, "radius": 0.1, "width": 0.05}
    (sensor,) = robot["sensors"]
    assert (sensor["lidar"], sensor["at"], sensor["yaw_deg"], sensor["pitch_deg"]) == ("scan", [0.1, 0, 0.2], 90, -5)
    assert (sensor["beams"], sensor["rate_hz"]) == (181, 5)
    navigator = robot["run"]["drivers"]["r"]["navigator"]
    assert navigator["points"] == [[1.2, 0], [1.2, 1.2], [0, 1.2], [0, 0]]


def test_wheels_between_the_axles_follow_the_front_ones():
    six = gear("skid_steer", [0.3, 0.0, -0.3])
    names = {name: [each.name for each in wheels] for name, wheels in wheels_by_name(six).items()}
    assert names == {
        "front_left": ["w0.30.2", "w00.2"],
        "front_right": ["w0.3-0.2", "w0-0.2"],
        "rear_left": ["w-0.30.2"],
        "rear_right": ["w-0.3-0.2"],
    }
    assert preset(six)["body"]["wheels"]["front_left"]["follow"] == ["w00.2"]
    car = preset(gear("ackermann", [0.3, -0.1], steer=(-0.5, 0.6)))["body"]["steering"]
    assert car == {"steer_front_left": "s0.2", "steer_front_right": "s-0.2"}
    one = gear("tricycle", [-0.1], single=(wheel(0.4, 0.0, steer=(-1.0, 1.2)),))
    assert preset(one)["body"]["steering"] == {"steer": "s0"}
    assert set(wheels_by_name(one)) == {"left", "right", "drive"}


@pytest.mark.parametrize(
    ("radius", "speed", "top", "source"),
    [
        (0.1, None, 1.25, "a guess"),
        (0.5, None, 1.5, "a guess"),  # not faster than that
        (0.1, 12.0, 1.2, "by the limits of its wheels, 12 rad/s"),
        (0.1, 100.0, 1.25, "a guess"),  # no limit
        (0.1, 0.1, 1.25, "a guess"),  # too slow to be one
        (0.1, 60.0, 1.25, "a guess"),  # too fast
        (0.0001, None, 0.05, "a guess"),
    ],
)
def test_the_top_speed_is_the_files_if_it_is_likely(radius, speed, top, source):
    plan = first_plan("r", "r.urdf", gear("differential", [0.0], radius=radius, speed=speed), STAND, ())
    assert max_speed(plan) == pytest.approx(top)
    assert speed_source(plan).startswith(source)
    assert preset_turn(plan) == round(min(170.0, max(20.0, math.degrees(2 * top / 0.4))))


def test_a_plan_takes_over_what_was_measured():
    plain = first_plan("r", "r.urdf", gear("differential", [0.0]), STAND, ()).measured(distance=1.1, turn=0.9)
    assert (plain.wheel_radius, plain.track) == (pytest.approx(0.11), pytest.approx(0.4 * 1.1 / 0.9))
    rolls = first_plan("r", "r.urdf", gear("mecanum", [0.2, -0.1]), STAND, ())
    rolls = rolls.measured(distance=1.1, turn=0.9, strafe=0.8)
    assert (rolls.track, rolls.strafe, rolls.spin) == (
        pytest.approx(0.7),
        pytest.approx(0.8 / 1.1),
        pytest.approx(0.9 / 1.1),
    )


@pytest.mark.parametrize(
    ("found", "kept"),
    [
        ({"left": 0.0005, "outward": 0.001}, {}),  # a usual car slips as much
        ({"left": 0.004, "turn": 0.0001}, {"left": 0.004}),
        ({"swing": 0.01, "outward": 0.009}, {"swing": 0.01, "outward": 0.009}),
    ],
)
def test_a_car_that_slips_more_than_usual_has_that_slip_in_its_plan(found, kept, monkeypatch):
    # The drives take minutes; what they show is given.
    given = slip.Learned(7, 0.0, 1.0, Slip(**found))
    monkeypatch.setattr(import_robot, "learned", lambda *_, **__: given)
    plan = first_plan("r", "r.urdf", gear("ackermann", [0.3, -0.1], steer=(-0.5, 0.6)), STAND, ())
    driven, notes = import_robot._steering(plan, {}, Path("r.urdf"))
    assert driven == (replace(plan, slip=Slip(**kept)) if kept else plan)
    assert len(notes) == bool(kept)
    assert all(f"{name} {value:.3g}" in note for note in notes for name, value in kept.items())


def test_steering_is_limited_by_the_least_side_and_by_90_degrees():
    free = gear("tricycle", [-0.1], single=(wheel(0.4, 0.0),))
    assert max_steer_deg(first_plan("r", "r", free, STAND, ())) == 90.0
    wide = gear("tricycle", [-0.1], single=(wheel(0.4, 0.0, steer=(-3.0, 3.0)),))
    assert max_steer_deg(first_plan("r", "r", wide, STAND, ())) == 90.0
    joints = [wheel(0, 0, steer=limits).steer for limits in ((-0.5, 0.4), (-0.3, 0.6))]
    assert steering_limit(joints) == 0.3
    assert steering_limit([]) == pytest.approx(math.radians(35.0))
    assert wheelbase_of(gear("ackermann", [0.3, 0.0, -0.2])) == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("text", "options", "drive", "names"),
    [
        (rover([0.2, -0.2]), {"left": ["l0_hinge"], "right": ["r0_hinge"]}, "differential", ["l0_hinge", "r0_hinge"]),
        (rover([0.0]), {}, "differential", ["l0_hinge", "r0_hinge"]),
        (rover([0.2, -0.2]), {}, "skid_steer", ["l0_hinge", "r0_hinge", "l1_hinge", "r1_hinge"]),
        (on_casters(), {"left": ["drive_a"], "right": ["drive_b"]}, "differential", None),
    ],
)
def test_named_wheels_are_those_that_drive(text, options, drive, names):
    here, stand = found(text, **options)
    assert here.drive == drive
    assert names is None or [each.name for each in here.wheels()] == names
    assert here.left == pytest.approx([-here.forward[1], here.forward[0]])
    left, right = (stand.point(side[0].middle) for side in here.rows[0])
    assert left[1] > 0.0 > right[1]
    assert left[2] == pytest.approx(here.rows[0][0][0].radius, abs=1e-3)


@pytest.mark.parametrize(
    ("text", "options", "said"),
    [
        (rover([0.0]), {"left": ["l0_hing"], "right": ["r0_hinge"]}, r"no hinge 'l0_hing' in r.urdf; did you mean"),
        (tricycle(), {"steering": ["none"]}, r"no hinge 'none' in r.urdf"),
        (rover([0.0]), {"drive": "hover"}, r"--drive is 'hover'; it must be one of differential,"),
        (rover([0.0]), {"drive": "mecanum"}, "wheels"),
        (rover([0.0]), {"drive": "skid_steer"}, "has one driven axle; skid steering needs two or more"),
        (rover([0.2, -0.2]), {"drive": "differential"}, "has 2 driven axles; a differential drive has one"),
        (rover([0.2, -0.2]), {"drive": "ackermann"}, "axles: 2, steered: 0; a car has two"),
        (rover([0.2, -0.2]), {"drive": "tricycle"}, "has no single steered wheel"),
        (rover([0.0]), {"forward": "+z"}, r"--forward is '\+z'; it must be \+x, -x, \+y or -y"),
        (rover([0.0]), {"forward": "+y"}, r"--forward \+y is along the axles of r.urdf"),
        (rover([0.2, -0.2]), {"left": ["l0_hinge", "l1_hinge"]}, "one behind the other, as on a bicycle"),
        (on_three(), {"drive": "mecanum"}, "leave out --drive mecanum"),
        (
            on_casters(),
            {"left": ["caster_front_swivel"], "right": ["drive_b"]},
            "the axle of a wheel must be horizontal",
        ),
    ],
)
def test_wheels_that_make_no_drive_are_refused_in_words(text, options, said):
    with pytest.raises(UsageError, match=said):
        found(text, **options)


@pytest.mark.parametrize(("forward", "way"), [("-x", -1.0), ("+x", 1.0), (None, 1.0)])
def test_the_user_says_which_end_is_the_front(forward, way):
    here, _ = found(rover([0.3, -0.1]), forward=forward)
    assert here.forward == pytest.approx([way, 0.0])
    assert here.rows[0][0][0].name == ("l0_hinge" if way > 0 else "r1_hinge")


MARKED = """<mujoco><worldbody><body name="base"><geom name="{0}" type="box" size=".02 .02 .02" pos="{1} 0 .1"/>
<geom name="{2}" type="box" size=".02 .02 .02" pos="{3} 0 .1"/>{4}
<body pos="0 .2 .1"><joint name="l" axis="0 1 0"/><geom type="cylinder" size=".1 .02" euler="90 0 0"/></body>
<body pos="0 -.2 .1"><joint name="r" axis="0 1 0"/><geom type="cylinder" size=".1 .02" euler="90 0 0"/></body></body>
</worldbody></mujoco>"""
LOOKS = '<camera pos="0 0 .2" xyaxes="0 {0} 0 0 0 1"/>'


@pytest.mark.parametrize(
    ("text", "way", "note"),
    [
        (MARKED.format("a", 0, "b", 0.01, ""), 1.0, "its front is +x in its file, as usual"),
        (MARKED.format("front", -0.3, "rear", 0.3, ""), -1.0, "by the names of its parts"),
        (MARKED.format("front", 0.3, "rear", -0.3, ""), 1.0, "by the names of its parts"),
        (MARKED.format("front", -0.3, "b", 0.3, ""), 1.0, "as usual"),  # one end alone says nothing
        (MARKED.format("front_of_back", -0.3, "rear", 0.3, ""), 1.0, "as usual"),
        (MARKED.format("a", 0, "b", 0.01, LOOKS.format(1)), -1.0, "and its cameras"),
        (MARKED.format("a", 0, "b", 0.01, LOOKS.format(-1)), 1.0, "and its cameras"),
    ],
)
def test_names_and_cameras_of_mjcf_tell_its_front(text, way, note):
    anatomy = anatomy_of(gather_robot("r.xml", lambda _: text.encode()))
    here = find_gear(anatomy, RobotOptions(), file="r.xml", urdf=False)
    assert here.forward == pytest.approx([way, 0.0], abs=1e-6)
    assert note in " ".join(here.notes)
