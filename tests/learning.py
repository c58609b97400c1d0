"""A room to learn in, and small things that the tests of environments share."""

from typing import Any

import numpy as np

from mjsim.env import Step, Task
from mjsim.world import World, parse_world

ROOM = """
mjsim: 1
name: learning
walls:
  - {points: [[0, 0], [6, 0], [6, 4], [0, 4]], closed: true, thickness: 0.1}
  - {points: [[6.05, 0], [9, 0], [9, 4], [6.05, 4]]}
obstacles:
  - {name: crate, box: [0.4, 0.4, 0.4], at: [3, 3], movable: true, mass: 3}
beacons: [{name: a, at: [5.9, 1]}, {name: b, at: [0.1, 3]}]
robots:
  - name: scout
    at: [1, 1]
    drive: {noise: {speed: 0.02, turn: 0.02}}
    odometry: {noise: {distance: 0.02, turn: 0.02}}
    sensors:
      - {lidar: scan, beams: 30, fov_deg: 270, range: [0.1, 4], noise: {range: 0.02}}
      - {beacons: ring, noise: {range: 0.05, bearing_deg: 1}}
      - {imu: inertia, noise: {acceleration: 0.02}, rate_hz: 125}
      - {camera: front, at: [0.15, 0, 0.3], width: 32, height: 24, rate_hz: 12.5, noise: 3}
  - {name: other, at: [1, 3], preset: turtlebot3_burger}
run:
  seconds: 4
  drivers:
    other: {navigator: {use: "mjsim.algorithms.waypoints:Waypoints", points: [[2, 3], [1, 3]], laps: 9}}
"""
NUMBERS = ("proximity", "bump", "odometry", "scan", "sightings", "inertia")
"""All that the robot of the room observes but pictures, which need OpenGL."""


def room(**changes: Any) -> World:
    """Return the room, with parts of it changed."""
    return parse_world(ROOM).model_copy(update=changes)


def advance(step: Step) -> float:
    """Return how far the robot came to the east in a step [m]."""
    return step.truth["scout"].x - step.before["scout"].x


def touched(step: Step) -> bool:
    """Say whether the robot touches anything."""
    return bool(step.seen["scout"].bump)


def task(**keys: Any) -> Task:
    """Return a task in the room, of numbers alone unless it says more."""
    return Task(**({"world": room(), "observations": NUMBERS, "reward": advance, "terminated": touched} | keys))


def alike(one: Any, other: Any) -> bool:
    """Say whether two observations, of arrays or of dicts of them, hold the same bytes."""
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(alike(one[key], other[key]) for key in one)
    return bool(one.dtype == other.dtype and one.shape == other.shape and np.all(one == other))
