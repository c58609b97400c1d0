"""What carries a robot from a file: casters of the file, and those that it lacks."""

import pytest

from mjsim.exchange import RobotOptions
from mjsim.exchange.robots.frame import find_stand
from mjsim.exchange.robots.gear import find_gear
from mjsim.exchange.robots.preset import Plan, first_plan, speed_source
from mjsim.models import anatomy_of, gather_robot
from tests.exchange.odd_robots import box, joint, robot, tyre

BASE = box("0.5 0.4 0.2", mass=40.0, at="0 0 0.16")
SPECK = '<collision><origin xyz="0 0 -0.1"/><geometry><box size="0.001 0.001 0.001"/></geometry></collision>'


def plan_of(links: dict[str, str], joints: list[str], limit: str = "") -> Plan:
    """Return the preset of a robot on two wheels with other parts."""
    wheels = {"l": tyre(0.1, 0.03), "r": tyre(0.1, 0.03)}
    places = [("left", "l", 0.25), ("right", "r", -0.25)]
    held = [joint(name, "base", wheel, f'xyz="0 {y} 0.1"', more=limit) for name, wheel, y in places]
    text = robot({"base": BASE, **wheels, **links}, [*held, *joints]).encode()
    found = anatomy_of(gather_robot("r.urdf", lambda _: text))
    gear = find_gear(found, RobotOptions(), file="r.urdf", urdf=True)
    return first_plan("r", "r.urdf", gear, find_stand(found, gear, acceleration=1.0), ())


def test_a_box_of_a_millimetre_marks_a_frame_and_carries_nothing():
    mark = joint("mark", "base", "footprint", 'xyz="0 0 0.1"', kind="fixed")
    assert [caster[:2] for caster in plan_of({"footprint": SPECK}, [mark]).stand.casters] == [(0.2, 0.0), (-0.2, 0.0)]


def test_a_caster_that_a_file_lacks_stands_below_the_base_not_below_an_arm():
    hold = joint("shoulder", "base", "arm", 'xyz="0.2 0 0.8"', kind="fixed")
    stand = plan_of({"arm": box("1.6 0.1 0.1", mass=1.0, at="0.8 0 0")}, [hold]).stand
    assert stand.radius == pytest.approx(1.8, abs=0.01)
    assert [caster[:2] for caster in stand.casters] == [(0.2, 0.0)]


def test_the_limit_of_the_wheels_is_told_as_the_file_has_it():
    plan = plan_of({}, [], limit='<limit effort="9" velocity="7.46"/>')
    assert speed_source(plan) == "by the limits of its wheels, 7.46 rad/s"
