"""Where drawings put the measurements of lidars, against angles and places that are written by hand."""

import math

import numpy as np
import pytest

from mjsim.sim.sensors import lidar_places
from mjsim.world import parse_world

WORLD = """
mjsim: 1
robots:
  - name: r
    at: [3, 4]
    heading_deg: 50
    sensors:
      - {lidar: low, at: [0.1, 0.2, 0.3], yaw_deg: 30}
      - {lidar3d: high, at: [0, -0.1, 0.5], yaw_deg: -90, pitch_deg: 20}
      - {camera: eye, at: [0, 0, 0.3]}
"""


def test_each_lidar_is_where_it_is_mounted_and_looks_up_with_its_pitch():
    places = lidar_places(parse_world(WORLD))
    assert set(places) == {"r/low", "r/high"}
    for name, at, yaw, pitch in (("r/low", (0.1, 0.2, 0.3), 30, 0), ("r/high", (0, -0.1, 0.5), -90, 20)):
        yaw, pitch = math.radians(yaw), math.radians(pitch)
        ahead = [math.cos(pitch) * math.cos(yaw), math.cos(pitch) * math.sin(yaw), math.sin(pitch)]
        left = [-math.sin(yaw), math.cos(yaw), 0.0]
        assert places[name][:3, 3] == pytest.approx(at)
        np.testing.assert_allclose(places[name][:3, :2].T, [ahead, left], atol=1e-12)
        np.testing.assert_allclose(places[name][:3, 2], np.cross(ahead, left), atol=1e-12)
