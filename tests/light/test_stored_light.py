"""Baked light: the same bits for any number of processes, and again from the cache."""

import shutil
import sys

import numpy as np
import pytest

from mjsim.compile import compile_world, compiled
from mjsim.errors import MjsimError
from mjsim.light import ALWAYS, GENERAL, LAMP, BakedLight, bake, light_of, linear, world_light
from mjsim.light.bake import sources_of
from mjsim.light.stored import key_of
from mjsim.output import user_cache
from mjsim.world import parse_world

ROOM = """mjsim: 1
shading: baked
walls:
  - {points: [[0, 0], [2, 0], [2, 2], [0, 2]], closed: true, openings: [{name: gate, at: 0.5, width: 0.9, door: {}}]}
obstacles:
  - {name: crate, box: [0.3, 0.3, 0.3], at: [1.4, 1.4]}
  - {name: ball, sphere: 0.2, at: [0.5, 1.5]}
lamps: [{name: desk, at: [1, 1]}, {name: hall, at: [0.5, 0.5]}]
run:
  events: [{time: 1, lamp: desk, brightness: 0}, {time: 2, open: gate}, {time: 3, remove: ball}]
"""


def compiled_world(text):
    world = parse_world(text)
    return world, compiled(compile_world(world))


@pytest.fixture(scope="module")
def room():
    return compiled_world(ROOM)


@pytest.fixture(scope="module")
def light(room):
    return bake(*room, processes=1, texel=0.2)


@pytest.fixture(autouse=True)
def own_cache(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    user_cache("light").mkdir(parents=True)


def arrays_of(light: BakedLight):
    for surface in light.surfaces:
        yield from (surface.points, surface.normals, surface.lightcoords, surface.triangles)
    for group in light.groups:
        yield from (group.texels, group.start)
    yield from (light.probes.origin, light.probes.spacing, light.probes.light, np.array(light.exposure))


def assert_same(one: BakedLight, other: BakedLight, *, rounding=0.0):
    assert [group.name for group in one.groups] == [group.name for group in other.groups]
    for left, right in zip(arrays_of(one), arrays_of(other), strict=True):
        np.testing.assert_allclose(left, right, rtol=0, atol=rounding)


@pytest.mark.slow
def test_light_is_the_same_to_the_last_bit_for_one_and_two_processes(room, light, monkeypatch, tmp_path):
    # Files of the folder that a user works in are no modules of the processes.
    (tmp_path / "pickle.py").write_text("raise SystemExit\n")
    monkeypatch.chdir(tmp_path)
    assert_same(light, bake(*room, processes=2, texel=0.2))


@pytest.mark.slow
def test_a_process_that_ends_early_is_named_in_one_line(room, monkeypatch):
    monkeypatch.setattr(sys, "executable", shutil.which("true"))
    with pytest.raises(MjsimError, match="a process that bakes light has ended"):
        bake(*room, processes=2, texel=0.2)


@pytest.mark.slow
def test_what_events_change_has_a_map_of_its_own_or_none(room, light):
    _, model = room
    assert [group.name for group in light.groups] == ["light", f"{LAMP}desk", f"{LAMP}hall", "door/gate"]
    lit = {model.geom(surface.geom).name for surface in light.surfaces}
    assert "obstacle/crate" in lit
    assert "obstacle/ball" not in lit
    assert not any(name.startswith("door/") for name in lit)
    gate = light.groups[3].texels
    assert gate.max() > 0.0 > gate.min()


@pytest.mark.parametrize(("events", "first"), [("", 1), ("run: {events: [{time: 1, lamp: l-6, brightness: 0}]}", 6)])
def test_lamps_that_events_change_and_then_the_first_have_maps_of_their_own_four_in_all(events, first):
    world = parse_world(f"lamps: [{{name: l, at: [1, 1], repeat: {{times: 6, offset: [1, 0]}}}}]\n{events}\n")
    rest = [number for number in range(1, 7) if number != first]
    own = sorted([first, *rest[:3]])
    assert sources_of(world, []).names == (GENERAL, ALWAYS, *(f"{LAMP}l-{number}" for number in own))


def test_what_does_not_change_light_does_not_change_its_key(room):
    robots = "robots: [{name: scout, preset: pioneer3dx, at: [1, 0.5]}]\nrun: {seconds: 7}\nmjsim: 1\n"
    base = "shading: baked\nwalls: [{points: [[0, 0], [2, 0], [2, 2], [0, 2]], closed: true}]\n"
    keys = {key_of(*compiled_world(text)) for text in (f"mjsim: 1\n{base}", f"{base}{robots}")}
    assert len(keys) == 1
    changed = (
        base.replace("[2, 2]", "[2.001, 2]"),
        base + "lamps: [{at: [1, 1]}]\n",
        base + "floor: {color: '#ff0000'}\n",
    )
    keys |= {key_of(*compiled_world(f"mjsim: 1\n{text}")) for text in changed}
    assert len(keys) == 4


def test_plain_shading_has_no_baked_light():
    assert light_of(*compiled_world("mjsim: 1\nwalls: [{points: [[0, 0], [2, 0]]}]\n")) is None


def test_without_embree_a_line_says_that_light_is_plain(monkeypatch, capsys, room):
    monkeypatch.setitem(sys.modules, "embreex.rtcore_scene", None)
    assert light_of(*room) is None
    (line,) = capsys.readouterr().err.splitlines()
    assert "plain light" in line
    assert "embreex" in line


@pytest.mark.slow
def test_light_is_baked_once_and_then_read(monkeypatch, room, light):
    baked = []
    monkeypatch.setattr(world_light, "_baked", lambda *arguments: baked.append(arguments) or light)
    assert_same(light_of(*room), light_of(*room))
    assert len(baked) == 1
    assert [file.suffix for file in user_cache("light").iterdir()] == [""]


@pytest.mark.slow
def test_light_that_the_cache_cannot_keep_is_baked_once_in_a_process_and_a_line_says_so(
    monkeypatch, tmp_path, capsys, room, light
):
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    baked = []
    monkeypatch.setattr(world_light, "_baked", lambda *arguments: baked.append(arguments) or light)
    assert_same(light_of(*room), light_of(*room))
    assert len(baked) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert f"Not a directory in {user_cache('light')}" in line


def test_linear_light_of_a_picture_value_is_its_power():
    assert linear(1.0) == 1.0
    assert linear(0.5) == pytest.approx(0.5**2.2)
