"""What is well written but cannot be meant is told with its place; what can be meant is let be."""

import pytest

from mjsim.world import World, check_world, parse_world
from mjsim.world.source import Source
from mjsim.world.structure import Opening, Wall

ROOM = "walls: [{points: [[0, 0], [6, 0], [6, 4], [0, 4]], closed: true, thickness: 0.2, name: hall}]\n"


def told(text, source=None):
    return [str(problem) for problem in check_world(parse_world(text, file="w", source=source))]


@pytest.mark.parametrize(
    ("text", "doubt"),
    [
        (ROOM + "robots: [{name: a, at: [3, 4]}]", "w:2:24: robot 'a' at [3, 4] starts inside wall 'hall'"),
        (ROOM + "robots: [{name: a, at: [3, 0.3]}]", "w:2:24: robot 'a' at [3, 0.3] starts inside wall 'hall'"),
        (
            "robots: [{name: a, at: [1, 1]}]\nobstacles: [{cylinder: [0.1, 1], at: [1.3, 1]}]",
            "w:1:24: robot 'a' at [1, 1] starts inside obstacles[0]; its body needs 0.22 m free all around",
        ),
        (
            "robots: [{name: a, at: [1, 1]}, {name: b, at: [1.4, 1]}]",
            "w:1:47: robot 'b' at [1.4, 1] starts inside robot 'a'",
        ),
        (ROOM + "beacons: [{name: r, at: [6, 2]}]", "w:2:25: beacon 'r' at [6, 2] hangs inside wall 'hall'"),
        (
            ROOM + "beacons: [{name: r, at: [5.89, 2], heading_deg: 0, image: f.png}]",
            "w:2:25: beacon 'r' at [5.89, 2] faces into wall 'hall', where it cannot be seen; turn it round",
        ),
        (
            "walls: [{points: [[0, 0], [2, 0]], openings: [{at: 1.5, width: 0.9}]}]",
            "w:1:64: this opening goes from 1.5 to 2.4 m; segment 0 is 2 m long, keep it within",
        ),
        (
            "walls: [{points: [[0, 0], [4, 0]], openings: [{at: 1, width: 1}, {at: 1.9, width: 1}]}]",
            "w:1:66: this opening overlaps openings[0] of its wall",
        ),
        (
            "walls: [{points: [[0, 0], [4, 0]], height: 2, openings: [{at: 1, width: 1, head: 2.2}]}]",
            "w:1:82: head is 2.2 m; the wall is 2 m high, keep it below",
        ),
        (
            "walls: [{points: [[0, 0], [4, 0]], height: 1, openings: [{at: 1, width: 1, sill: 1.2}]}]",
            "w:1:82: sill is 1.2 m; the wall is 1 m high, keep it below",
        ),
    ],
)
def test_what_cannot_be_meant_is_told(text, doubt):
    (line,) = told(text, Source(file="w", attached={"f.png": b""}))
    assert line.startswith(doubt)


@pytest.mark.parametrize(
    "text",
    [
        ROOM + "robots: [{name: a, at: [0.32, 0.32]}, {name: b, at: [0.76, 0.32]}]",
        ROOM
        + "beacons: [{name: r, at: [5.89, 2], heading_deg: 180, image: f.png}, {name: s, at: [0.1, 2], center: 3}]",
        ROOM + "beacons: [{name: r, at: [5.9, 2], heading_deg: 0}]",  # a reflector has no front
        "walls: [{points: [[0, 0], [4, 0]], openings: [{at: 1, width: 1}]}]\nrobots: [{name: a, at: [1.5, 0]}]",
        "walls: [{points: [[0, 0], [4, 0]], height: 1, openings: [{at: 1, width: 1}]}]",
        "walls: [{points: [[0, 0], [4, 0]], openings: [{at: 1, width: 1}, {at: 2, width: 2}]}]",
        "walls: [{points: [[0, 0], [4, 0]], openings: [{at: 1, width: 1, head: 1}, {at: 1, width: 1, sill: 1.5}]}]",
    ],
)
def test_what_can_be_meant_is_let_be(text):
    assert told(text, Source(file="w", attached={"f.png": b""})) == []


def test_a_world_built_in_python_is_checked_too():
    world = World(walls=(Wall(points=((0, 0), (1, 0)), openings=(Opening(at=0.5, width=1),)),))
    (problem,) = check_world(world)
    assert str(problem).startswith("world:1:1: this opening goes from 0.5 to 1.5 m")


MODULE = """
raise SystemExit("this must not run")
import math as geometry
from somewhere import Brought
class Avoid: pass
if True:
    class Inner: pass
Alias: type = Avoid
"""


@pytest.mark.parametrize(
    ("use", "doubt"),
    [
        ("mine.py:Avoid", None),
        ("mine.py:Inner", None),
        ("mine.py:Alias", None),
        ("mine.py:Brought", None),
        ("package/deep.py:Star", None),
        ("mjsim.algorithms.ekf_slam:EkfSlam", None),
        ("collections:OrderedDict", None),
        ("math:Anything", None),
        ("mine.py:Avoyd", "no class 'Avoyd' in mine.py; did you mean 'Avoid'?"),
        ("min.py:Avoid", "no file 'min.py' beside the world file; did you mean 'mine.py'?"),
        ("../mine.py:Avoid", "path '../mine.py' leaves the folder of the world; keep it beside the world file"),
        ("broken.py:Avoid", "broken.py:2: '(' was never closed; this is not Python"),
        ("mjsim.algorithms.ekf_slam:EkfSlm", "no class 'EkfSlm' in mjsim.algorithms.ekf_slam; did you mean 'EkfSlam'?"),
        ("mjsim.algorithms.none:X", "no module 'mjsim.algorithms.none' is installed; install it or mend the name"),
        ("none.such:X", "no module 'none' is installed; install it or mend the name"),
        ("not a module:X", "'not a module' is not a module; write 'package.module:Class' or 'file.py:Class'"),
    ],
)
def test_classes_are_looked_for_without_running_anything(tmp_path, use, doubt):
    (tmp_path / "mine.py").write_text(MODULE)
    (tmp_path / "broken.py").write_text("x = 1\ny = (\n")
    (tmp_path / "package").mkdir()
    (tmp_path / "package" / "deep.py").write_text("from mine import *\n")
    text = f"robots: [{{name: a, at: [0, 0]}}]\nrun: {{drivers: {{a: {{navigator: {{use: '{use}'}}}}}}}}"
    lines = told(text, Source(file="w", folder=tmp_path))
    assert lines == ([f"w:2:38: {doubt}"] if doubt else [])
