"""Beacons are measured through a lens as without one, and count as seen in a given range only."""

import math

import numpy as np
import pytest

from mjsim.algorithms.beacon_vision.beacon_vision import BeaconVision
from mjsim.algorithms.beacon_vision.rectification import Rectifier
from mjsim.interface import Sighting
from mjsim.sim import Simulation
from mjsim.world import parse_world

WORLD = """
mjsim: 1
walls: [{points: [[-1, -3], [4, -3], [4, 3], [-1, 3]], closed: true, thickness: 0.2}]
beacons:
  - {name: lion, image: posters/lion.jpg, at: [3.89, 0.5], heading_deg: 180, width: 0.6, center: 0.8}
  - {name: owl, image: posters/owl.jpg, at: [1.8, -1.0], heading_deg: 160, width: 0.6, center: 0.8}
robots:
  - {name: r, at: [0, 0], sensors: [{camera: front, at: [0, 0, 0.6], width: 640, height: 480, fov_deg: 80, KEYS}]}
"""
PLACES = {"lion": (3.89, 0.5), "owl": (1.8, -1.0)}


def sightings(keys: str, **options: object) -> dict[str | None, Sighting]:
    with Simulation(parse_world(WORLD.replace("KEYS", keys))) as sim:
        observer = BeaconVision("front", **options)
        observer.start(sim.robots["r"], sim.catalogue, np.random.default_rng(0))
        return {seen.name: seen for seen in observer.observe(sim.sense("r"))}


@pytest.mark.slow
@pytest.mark.parametrize("lens", ["noise: 0", "lens: {brown: [-0.2, 0.04, 0, 0, 0]}", "lens: {fisheye: [0, 0, 0, 0]}"])
def test_pictures_are_measured_through_a_lens_as_without_one(lens):
    seen = sightings(lens)
    assert set(seen) == set(PLACES)
    for name, (x, y) in PLACES.items():
        assert seen[name].range == pytest.approx(math.hypot(x, y), rel=0.01), name
        assert seen[name].bearing == pytest.approx(math.atan2(y, x), abs=0.004), name


@pytest.mark.slow
def test_a_beacon_counts_as_seen_in_its_range_only():
    assert set(sightings("noise: 0", range=[0.5, 3.0])) == {"owl"}
    assert set(sightings("noise: 0", range=[3.0, 9.0])) == {"lion"}
    with pytest.raises(ValueError, match="range is"):
        BeaconVision("front", range=[3.0, 2.0])


@pytest.mark.slow
def test_a_straight_picture_is_that_of_a_pinhole_and_a_pinholes_stays_as_it_is():
    frames = []
    for lens in ("noise: 0", "lens: {brown: [-0.2, 0.04, 0.001, 0, 0]}"):
        with Simulation(parse_world(WORLD.replace("KEYS", lens))) as sim:
            frames.append(sim.sense("r").cameras["front"])
    plain, bent = frames
    assert Rectifier(plain.intrinsics).straight(plain) is plain
    straight = Rectifier(bent.intrinsics).straight(bent)
    assert straight.intrinsics.lens == "pinhole"
    # The lens makes the focal length another; look up each straight pixel in the pinhole's own picture.
    K, straight_K = plain.intrinsics, straight.intrinsics
    v, u = np.mgrid[150:330:7, 200:440:7]
    x, y = (u - straight_K.cx) / straight_K.fx, (v - straight_K.cy) / straight_K.fy
    expected = plain.image[np.rint(y * K.fy + K.cy).astype(int), np.rint(x * K.fx + K.cx).astype(int)].astype(int)
    apart = np.abs(straight.image[v, u].astype(int) - expected).max(axis=-1)
    # But for edges, which two samplings draw a pixel apart.
    assert np.median(apart) <= 2
    assert (apart > 40).mean() < 0.08
