"""Files that no thing can be: each is refused in one line at the world's line, whatever it holds."""

import struct
import sys
from pathlib import Path

import numpy as np
import pytest

from mjsim.errors import WorldError
from mjsim.world import load_world
from tests.children import LIMIT, completed

FUZZ = Path(__file__).parents[2] / "scripts" / "fuzz" / "importers.py"


def world_of(folder, obstacle):
    path = folder / "world.yaml"
    path.write_text(f"mjsim: 1\nobstacles:\n  - {{{obstacle}}}\n")
    return load_world(path)


def stl(corners):
    triangles = b"".join(struct.pack("<12fH", 0, 0, 0, *np.ravel(each), 0) for each in corners)
    return bytes(80) + struct.pack("<I", len(corners)) + triangles


HOSTILE = {
    "an include from outside": ('<mujoco><include file="../secret.xml"/></mujoco>', "names the file '../secret.xml'"),
    "a folder of the system": (
        '<mujoco><compiler meshdir="/etc"/><asset><mesh file="passwd.obj"/></asset></mujoco>',
        "names the file '/etc/passwd.obj'",
    ),
    "a way up": ('<mujoco><asset><texture file="../../a.png"/></asset></mujoco>', "names the file '../../a.png'"),
    "a link that leads out": ('<mujoco><include file="out/secret.xml"/></mujoco>', "is outside its folder"),
    "a file that is not there": ('<mujoco><asset><mesh file="none.obj"/></asset></mujoco>', "no file 'none.obj'"),
    "a plugin": ('<mujoco><extension><plugin plugin="x"/></extension></mujoco>', "has plugins (<extension>)"),
    "a document type": ('<!DOCTYPE a [<!ENTITY b "c">]><mujoco/>', "declares a document type"),
    "a loop": ('<mujoco><include file="bad.xml"/></mujoco>', "includes files more than 16 deep"),
    "a million parts": (
        '<mujoco><worldbody><replicate count="1000000"><geom size="1"/></replicate></worldbody></mujoco>',
        "has 1000000 parts; it must have at most 2000",
    ),
    "a deep nest": ("<mujoco>" + "<body>" * 100, "is nested more than 64 deep"),
    "no XML": ("<mujoco><geom></mujoco>", "is not XML: mismatched tag"),
    "another kind of XML": ("<svg/>", "begins with <svg>; a model begins with <mujoco> (MJCF) or <robot> (URDF)"),
    "nothing solid": ("<mujoco/>", "has no shape; give it geoms"),
    "no number": (
        '<mujoco><worldbody><geom size="a"/></worldbody></mujoco>',
        "MuJoCo cannot read 'bad.xml': XML Error: bad format in attribute 'size'",
    ),
    "no size of a thing": (
        '<mujoco><worldbody><geom size="1e9"/></worldbody></mujoco>',
        "it extends to 1e+09 units, too large for an object; check its units",
    ),
    "no end": (
        '<mujoco><worldbody><geom size="1"/><geom size="inf"/><geom size="1"/></worldbody></mujoco>',
        "too large for an object",
    ),
    "too far": (
        '<mujoco><worldbody><body pos="9e5 0 0"><geom size="1" pos="9e5 0 0"/></body></worldbody></mujoco>',
        "extends to 1.8e+06 units",
    ),
    "something endless that is only seen": (
        '<mujoco><worldbody><geom size="1"/><geom size="1e308" contype="0" conaffinity="0"/></worldbody></mujoco>',
        "it extends to 1e+308 units, too large for an object; check its units",
    ),
    "no class": (
        '<mujoco><worldbody><geom class="x"/></worldbody></mujoco>',
        "XML Error: unknown default class name 'x'",
    ),
    "a height field": ('<mujoco><asset><hfield name="a"/></asset></mujoco>', "has a height field (<hfield>)"),
    "a wall of numbers": (
        f'<mujoco><a b="{"1 " * 4_100_000}"/></mujoco>',
        "has more than 8 MB of XML; make it simpler",
    ),
    "pictures out of nothing": (
        "<mujoco><asset>"
        + '<texture builtin="flat" type="cube" width="4000" height="4000"/>' * 2
        + "</asset></mujoco>",
        "have more than 100 megapixels; make them smaller",
    ),
    "many large meshes": (
        '<mujoco><asset><mesh name="m" file="large.obj"/></asset><worldbody><replicate count="20">'
        '<geom type="mesh" mesh="m"/></replicate></worldbody></mujoco>',
        "its parts have more than 1200000 corners; simplify its meshes",
    ),
    "a mesh too large": (
        '<mujoco><asset><mesh name="m" file="larger.obj"/></asset><worldbody>'
        '<geom type="mesh" mesh="m"/></worldbody></mujoco>',
        "'larger.obj' has 210000 corners; a mesh has 4 to 200000, simplify it",
    ),
    "a broken mesh": ('<mujoco><asset><mesh file="broken.stl"/></asset></mujoco>', None),
}


LARGE = {"many large meshes"}


@pytest.mark.parametrize("hostile", [pytest.param(n, marks=[pytest.mark.slow] if n in LARGE else []) for n in HOSTILE])
def test_a_file_that_no_thing_can_be_is_refused_in_one_line(tmp_path, hostile):
    text, message = HOSTILE[hostile]
    place = tmp_path / "world"
    place.mkdir()
    (tmp_path / "secret.xml").write_text('<mujoco><worldbody><geom size="1"/></worldbody></mujoco>')
    (place / "out").symlink_to(tmp_path)
    for name, times in (("large", 1), ("larger", 3)):
        if f"{name}.obj" in text:
            (place / f"{name}.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 1 1 1\n" * 14_000 * times)
    (place / "broken.stl").write_bytes(stl(np.zeros((2, 3, 3)))[:-1])
    if hostile == "a broken mesh":
        geoms = '<worldbody><geom type="mesh" mesh="broken"/></worldbody></mujoco>'
        text, message = text.replace("</mujoco>", geoms), "cannot be read as a mesh; export it again as OBJ"
    (place / "bad.xml").write_text(text)
    with pytest.raises(WorldError) as caught:
        world_of(place, "name: bad, at: [1, 1], model: bad.xml")
    (problem,) = caught.value.problems
    assert (problem.line, problem.column) == (3, 36)
    assert message in problem.message
    assert "'" in problem.message


@pytest.mark.slow
def test_any_change_of_a_model_leaves_a_thing_or_one_line():
    command = [sys.executable, str(FUZZ), "thing in MJCF", "--inputs", "16", "--seed", "7"]
    row = completed(command, within=4 * LIMIT).stdout.splitlines()[-1]
    inputs, _, accepted, refused, *_ = map(int, row.split("|")[2:-1])
    assert inputs == 16
    assert min(accepted, refused) > 2
