"""Masses of robots from files whose links are weighed apart from their shapes."""

from pathlib import Path
from xml.etree import ElementTree

import pytest

import mjsim
from mjsim.exchange import RobotOptions, bring_robot
from mjsim.exchange.robots.driven_wheels import find_gear
from mjsim.exchange.robots.omni import without_rollers
from mjsim.exchange.robots.preset import first_plan, preset_text
from mjsim.exchange.robots.robot_frame import find_stand
from mjsim.models import anatomy_of, gather_robot
from tests.exchange.bringing import brought
from tests.exchange.odd_robots import joint, on_mecanum, on_three, robot, tyre

DATA = Path(__file__).parents[1] / "data" / "robots"
pytestmark = pytest.mark.slow  # Each robot is driven to be measured.

BARE = '<collision><geometry><box size="{size}"/></geometry></collision>'
WHEELS = [joint("left", "base", "l", 'xyz="0 0.2 0"'), joint("right", "base", "r", 'xyz="0 -0.2 0"')]


def fixed(parent: str, child: str) -> str:
    """Return a joint that holds a link."""
    return f'<joint name="{child}_hold" type="fixed"><parent link="{parent}"/><child link="{child}"/></joint>'


def weighed(links: dict[str, str], joints: list[str], tmp_path) -> tuple[str, float]:
    """Return what is said of a robot, and what it weighs in a world [kg]."""
    (tmp_path / "robot.urdf").write_text(robot(links, [*WHEELS, *joints]))
    preset, said = brought(tmp_path / "robot.urdf", tmp_path)
    with mjsim.Simulation(mjsim.load_world(preset)) as sim:
        bodies = [k for k in range(sim.model.nbody) if sim.model.body(k).name.startswith("robot/")]
        return said, float(sim.model.body_mass[bodies].sum())


@pytest.mark.parametrize("mass", ["", '<inertial><mass value="0"/></inertial>'])
def test_links_without_a_mass_that_are_fixed_to_one_with_a_mass_weigh_nothing(mass, tmp_path):
    # As in the files of the Husky: the shapes are on one link, the mass on another that is fixed to it.
    shapes = BARE.format(size="0.4 0.3 0.1")
    heavy = '<inertial><mass value="7"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial>'
    links = {"base": mass + shapes, "inertial_link": heavy, "l": tyre(0.08, 0.03), "r": tyre(0.08, 0.03)}
    said, kilograms = weighed(links, [fixed("base", "inertial_link")], tmp_path)
    wheels = float(links["l"].partition('mass value="')[2].partition('"')[0])
    assert f"URDF of {7 + 2 * wheels:.3g} kg" in said
    assert kilograms == pytest.approx(7 + 2 * wheels, abs=1e-3)  # Links that weigh nothing have 1e-6 kg each.
    assert "imu" not in said


def test_a_mass_below_zero_is_named(tmp_path):
    light = '<inertial><mass value="-2.3"/></inertial>' + BARE.format(size="0.4 0.3 0.1")
    heavy = '<inertial><mass value="7"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial>'
    links = {"base": light, "inertial_link": heavy, "l": tyre(0.08, 0.03), "r": tyre(0.08, 0.03)}
    said, _ = weighed(links, [fixed("base", "inertial_link")], tmp_path)
    assert "link 'base' has a mass of -2.3 kg; it gets a negligible mass instead" in said


def test_the_shipped_waffle_weighs_what_its_file_says():
    file = DATA / "turtlebot3_description" / "urdf" / "turtlebot3_waffle.urdf"
    told = sum(float(mass.get("value", "")) for mass in ElementTree.parse(file).iter("mass"))
    model = mjsim.compile_world(mjsim.load_world("waffle")).compile()
    assert float(model.body("scout/base").subtreemass[0]) == pytest.approx(told, abs=1e-4)


def test_a_part_without_any_mass_weighs_what_its_shapes_do_and_is_named(tmp_path):
    links = {"base": BARE.format(size="0.4 0.3 0.1"), "l": tyre(0.08, 0.03), "r": tyre(0.08, 0.03)}
    (tmp_path / "robot.urdf").write_text(robot(links, WHEELS))
    made = bring_robot(tmp_path / "robot.urdf", name="r", options=RobotOptions(), packages={}, arguments={})
    assert any("'base' has no mass; its shapes get a density of 1000 kg/m^3 instead" in line for line in made.report)


@pytest.mark.parametrize("text", [on_three(), on_mecanum(), on_mecanum(rollers=8)])
def test_a_robot_on_rollers_weighs_what_its_file_says(text, tmp_path):
    (tmp_path / "robot.urdf").write_text(text)
    told = sum(float(mass.get("value", "")) for mass in ElementTree.fromstring(text).iter("mass"))
    found = gather_robot("robot.urdf", lambda name: (tmp_path / name).read_bytes())
    gear = find_gear(anatomy_of(found), RobotOptions(), file="robot.urdf", urdf=True)
    stand = find_stand(without_rollers(anatomy_of(found))[0], gear, acceleration=1.0)
    plan = first_plan("robot", "robot.urdf", gear, stand, ())
    (tmp_path / "robot.yaml").write_text(preset_text(plan, ()))
    model = mjsim.compile_world(mjsim.load_world(tmp_path / "robot.yaml")).compile()
    assert float(model.body("robot/base").subtreemass[0]) == pytest.approx(told, rel=2e-3)
