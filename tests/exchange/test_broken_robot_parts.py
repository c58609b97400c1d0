"""Broken files of robots in the manner of exporters, with meshes, controllers and xacro: a line each, exit code 2."""

import re

import pytest

from tests.exchange.bringing import typed
from tests.exchange.odd_robots import box, joint, robot, tyre
from tests.models.test_mesh_files import collada

BASE = box("0.5 0.4 0.2", mass=40.0, at="0 0 0.16")
WHEELS = [joint("left", "base", "l", 'xyz="0 0.25 0.1"'), joint("right", "base", "r", 'xyz="0 -0.25 0.1"')]
LINKS = {"base": BASE, "l": tyre(0.1, 0.03), "r": tyre(0.1, 0.03)}
ONLY = '<inertial><mass value="1"/></inertial><visual><geometry><mesh filename="{}"/></geometry></visual>'
XACRO = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">{}</robot>'


def meshed(name: str) -> str:
    """Return a robot all of whose shapes are one mesh."""
    return robot(dict.fromkeys(LINKS, ONLY.format(name)), WHEELS)


WHOLE = robot(LINKS, WHEELS)
CASES = {
    "every mesh is missing": (meshed("a.dae"), (), "the wheels have no shape|no wheels"),
    "every mesh is broken": (meshed("b.dae"), (), "the wheels have no shape|no wheels"),
    "a mesh with an entity": (meshed("e.dae"), (), "the wheels have no shape|no wheels"),
    "meshes that are no wheels": (meshed("t.dae"), (), "is round about its axle|no wheels"),
    "no name after a package": (meshed("package://"), (), "the wheels have no shape|no wheels"),
    "a steering joint that is a wheel": (WHOLE, ("--steering", "left"), "--steering 'left' .* turns no wheel"),
    "a steering joint that is not there": (WHOLE, ("--steering", "lft"), "no hinge 'lft' .*did you mean 'left'"),
    "a steering joint of a slide": (
        robot({**LINKS, "m": BASE}, [*WHEELS, joint("lift", "base", "m", 'xyz="0 0 1"', kind="prismatic")]),
        ("--steering", "lift"),
        "no hinge 'lift'",
    ),
    "a car of a robot that does not steer": (WHOLE, ("--drive", "ackermann"), "a car has two"),
    "two wheels in one place": (
        robot(LINKS, [joint("left", "base", "l", 'xyz="0 0 0.1"'), joint("right", "base", "r", 'xyz="0 0 0.1"')]),
        (),
        "ambiguous|one behind the other",
    ),
    "a macro of a missing include": (
        XACRO.format('<xacro:include filename="$(find gone)/a.xacro"/><link name="a"/><xacro:thing/>'),
        (),
        "no macro is called 'thing'; .*--package gone=DIR",
    ),
    "a property of a missing include": (
        XACRO.format('<xacro:include filename="$(find gone)/a.xacro"/><link name="${thing}"/>'),
        (),
        "no xacro:property 'thing'.*--package gone=DIR",
    ),
    "a missing include alone": (
        XACRO.format('<xacro:include filename="$(find gone)/a.xacro"/>'),
        (),
        "give --package gone=DIR",
    ),
    "a missing file alone": (XACRO.format('<xacro:include filename="a.xacro"/>'), (), "no file .*a.xacro"),
    "an argument without a value": (XACRO.format('<link name="$(arg prefix)a"/>'), (), "give --arg prefix=VALUE"),
    "an argument that is no pair": (WHOLE, ("--arg", "prefix"), "'prefix' is not NAME=VALUE"),
    "a package that is no folder": (WHOLE, ("--package", "a=/nowhere"), "no folder '/nowhere' for package 'a'"),
    "masses of rounding alone": (
        robot(dict.fromkeys(LINKS, '<inertial><mass value="4e-15"/></inertial>'), WHEELS),
        (),
        "no wheels|have no shape",
    ),
    "a plug-in with a radius of nothing": (
        robot(
            dict.fromkeys(LINKS, '<inertial><mass value="1"/></inertial>'),
            [
                *WHEELS,
                '<gazebo><plugin name="d"><joint>left</joint><wheelDiameter>0</wheelDiameter></plugin></gazebo>',
            ],
        ),
        (),
        "no wheels|have no shape",
    ),
    "a wheel that only steers": (
        robot(LINKS, [item.replace('"0 1 0"', '"0 0 1"') for item in WHEELS]),
        (),
        "no level hinge|no wheels",
    ),
}


@pytest.mark.parametrize("case", list(CASES))
def test_a_broken_robot_is_one_line(tmp_path, case):
    text, options, says = CASES[case]
    (tmp_path / "b.dae").write_bytes(collada("", "")[:400])
    (tmp_path / "t.dae").write_bytes(collada("", ""))
    (tmp_path / "e.dae").write_bytes(b'<!DOCTYPE a [<!ENTITY b "c">]>' + collada("", "").partition(b"?>")[2])
    place = tmp_path / ("r.xacro" if "xacro" in text else "r.urdf")
    place.write_text(text)
    code, said = typed("new", "--robot-from", str(place), "-o", str(tmp_path / "o.yaml"), *options)
    assert (code, len(said.splitlines())) == (2, 1), said
    assert re.search(says, said), said
