"""Baked light as a whole: conserved, weighted, rounded and kept."""

import math
import sys

import numpy as np
import pytest

from mjsim.compile import compile_world, compiled
from mjsim.light import GENERAL, LAMP, bake
from mjsim.light.bake import rounded
from mjsim.light.baked import BakedLight, LightGroup, coded, linear
from mjsim.light.emitters import lamp_color, lamp_rectangle
from mjsim.light.stored import baking, store, stored
from mjsim.output import user_cache
from mjsim.world import Lamp, parse_world

CLOSED = """mjsim: 1
light: 0.5
walls: [{points: [[0, 0], [2, 0], [2, 2], [0, 2]], closed: true, height: 2, color: "#bababa"}]
floor: {color: "#bababa"}
ceiling: {color: "#bababa", height: 2}
lamps: [{name: l, at: [1, 1], height: 1.9, color: "#ff8000", brightness: 0.6}]
"""


@pytest.fixture(scope="module")
def light():
    world = parse_world(CLOSED)
    return bake(world, compiled(compile_world(world)), processes=1, texel=0.4)


def test_reflection_in_a_closed_room_neither_makes_nor_loses_light(light):
    (lamp,) = (group for group in light.groups if group.name == f"{LAMP}l")
    total, shares = 0.0, np.random.default_rng(0).dirichlet((1, 1, 1), 200)
    for surface in light.surfaces:
        corners, size = surface.points[surface.triangles], lamp.texels.shape[1::-1]
        area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
        inside = (np.abs(shares @ corners - 1) < 1 + 1e-6).all(axis=2)
        columns, rows = np.floor(shares @ surface.lightcoords[surface.triangles] * size).astype(int).T
        total += (lamp.texels[rows, columns, 0].astype(float).T * inside).mean(axis=1) @ area
    rectangle = lamp_rectangle(Lamp(at=(1.0, 1.0), height=1.9))
    flux, albedo = math.pi * rectangle.radiance * rectangle.area, (0xBA / 255) ** 2.2
    assert total == pytest.approx(flux / (1 - albedo), rel=0.04)
    np.testing.assert_allclose(lamp.start, lamp_color("#ff8000") * 0.6**2.2)
    np.testing.assert_allclose(light.groups[0].start, 0.5**2.2)


def test_light_of_a_picture_is_the_weighted_sum_of_its_groups_exposed_and_never_negative():
    rng = np.random.default_rng(0)
    groups = tuple(
        LightGroup(name, rng.normal(size=(2, 3, 3)).astype(np.float16), rng.random(3)) for name in (GENERAL, "door/a")
    )
    light = BakedLight((), groups, None, 0.5)
    weights = light.weights({"door/a": np.array([1.0, 2.0, 3.0])})
    np.testing.assert_array_equal(weights, [groups[0].start, [1.0, 2.0, 3.0]])
    exact = 0.5 * sum(group.texels.astype(float) * weight for group, weight in zip(groups, weights, strict=True))
    np.testing.assert_allclose(light.total(weights), np.maximum(exact, 0.0), atol=1e-6)
    assert coded(np.float32([-1.0, 0.0, 0.5, 1.0, 9.0])).tolist() == [0, 0, round(255 * 0.5 ** (1 / 2.2)), 255, 255]
    np.testing.assert_allclose(coded(linear(np.arange(256) / 255).astype(np.float32)), np.arange(256))


def test_rounded_light_is_within_half_of_an_eighth_of_its_last_bits():
    values = np.random.default_rng(0).uniform(0.01, 60.0, 500).astype(np.float32)
    off = rounded(np.concatenate([values, -values])).astype(float) / np.concatenate([values, -values]) - 1
    assert np.abs(off).max() <= 2.0**-8 * 1.07
    assert abs(off.mean()) < 4e-4
    assert rounded(np.float32([1e9, -1e9])).tolist() == pytest.approx([6e4, -6e4], rel=0.01)
    assert len(np.unique(rounded(np.linspace(1, 2, 2000, dtype=np.float32)))) == 129


def test_light_comes_back_from_the_cache_as_it_was_and_what_is_broken_or_foreign_is_none(light, monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    folder = user_cache("light")
    with baking("key", lambda: False):
        kept = store("key", light)
        assert (folder / "key.lock").exists()
    again = stored("key")
    for one, other in ((kept, again), (light, again)):
        assert [(group.name, group.gain, group.angle) for group in one.groups] == [
            (group.name, group.gain, group.angle) for group in other.groups
        ]
        assert one.exposure == other.exposure
        for left, right in zip(one.surfaces, other.surfaces, strict=True):
            assert left.geom == right.geom
            np.testing.assert_array_equal(left.triangles, right.triangles)
            for name in ("points", "normals", "lightcoords"):
                np.testing.assert_allclose(getattr(left, name), getattr(right, name), atol=1e-3)
        for left, right in zip(one.groups, other.groups, strict=True):
            np.testing.assert_array_equal(left.texels, right.texels)
            np.testing.assert_array_equal(left.start, right.start)
        np.testing.assert_array_equal(one.probes.light, other.probes.light)
        np.testing.assert_array_equal(one.probes.origin, other.probes.origin)
        np.testing.assert_array_equal(one.probes.spacing, other.probes.spacing)
    assert [file.name for file in folder.iterdir()] == ["key"]
    data = (folder / "key").read_bytes()
    (folder / "other").write_bytes(data)
    assert stored("other") is None
    for broken in (b"", data[:-100], b"PK" + data[7:]):
        (folder / "key").write_bytes(broken)
        assert stored("key") is None
    monkeypatch.setattr(sys.modules["mjsim.light.stored"], "MAX_BYTES", len(data) + 10)
    store("new", light)
    assert [file.name for file in folder.iterdir()] == ["new"]
