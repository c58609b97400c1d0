"""A drive of the user's own, on a robot from a file of MJCF."""

import math

import pytest

from mjsim.errors import UsageError, WorldError
from mjsim.interface import Command, WheelCommand
from mjsim.sim import Simulation
from mjsim.world import load_world, parse_world

ROVER = """
<mujoco>
  <compiler angle="degree"/>
  <worldbody>
    <body name="base">
      <freejoint/>
      <geom type="box" size="0.2 0.12 0.05" pos="0 0 0.1" mass="4" rgba="0.2 0.5 0.8 1"/>
      <geom type="sphere" size="0.04" pos="-0.15 0 0.04" mass="0.1" condim="1" friction="0 0 0" priority="1"/>
      <geom type="sphere" size="0.04" pos="0.15 0 0.04" mass="0.1" condim="1" friction="0 0 0" priority="1"/>
      <body name="left" pos="0 0.15 0.08">
        <joint name="left" axis="0 1 0" armature="0.05"/>
        <geom type="ellipsoid" size="0.08 0.02 0.08" mass="0.3"/>
      </body>
      <body name="right" pos="0 -0.15 0.08">
        <joint name="right" axis="0 1 0" armature="0.05"/>
        <geom type="ellipsoid" size="0.08 0.02 0.08" mass="0.3"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <velocity name="left" joint="left" kv="4"/>
    <velocity name="right" joint="right" kv="4"/>
  </actuator>
</mujoco>
"""
TANK = """
class Tank:
    wheels = ("left", "right")

    def __init__(self, radius, track):
        self.radius, self.track = radius, track

    def wheels_from_twist(self, forward, left, turn):
        half = turn * self.track / 2
        return (forward - half) / self.radius, (forward + half) / self.radius

    def twist_from_wheels(self, speeds):
        left, right = speeds
        return self.radius * (left + right) / 2, 0.0, self.radius * (right - left) / self.track
"""
WORLD = """
mjsim: 1
walls: [{points: [[3, -2], [3, 2]]}]
robots:
  - {name: rover, at: [0, 0], heading_deg: 0, body: {model: rover.xml, radius: 0.25, height: 0.15},
     drive: {use: "tank.py:Tank", radius: 0.08, track: 0.3, max_speed: 0.5}}
"""


@pytest.fixture
def rover(tmp_path):
    (tmp_path / "rover.xml").write_text(ROVER)
    (tmp_path / "tank.py").write_text(TANK)
    (tmp_path / "room.yaml").write_text(WORLD)
    return tmp_path / "room.yaml"


def test_it_drives_and_tells_its_motion_as_the_users_class_says(rover):
    with Simulation(load_world(rover)) as sim:
        info = sim.robots["rover"]
        assert (info.drive, info.wheels) == ("Tank", ("left", "right"))
        sim.apply("rover", Command(0.4))
        way = 0.0
        for _ in range(100):
            sim.step()
            way += sim.sense("rover").odometry.forward
        assert sim.truth("rover").x == pytest.approx(1.6, rel=0.08)
        assert way == pytest.approx(sim.truth("rover").x, rel=0.02)
        sim.apply("rover", WheelCommand((-2.0, 2.0)))
        before = sim.truth("rover").heading
        for _ in range(50):
            sim.step()
        # 2 rad/s on 0.08 m wheels 0.3 m apart, for two seconds less what it takes to brake and to gather speed.
        assert sim.truth("rover").heading - before == pytest.approx(2.0 * 0.08 * 2 / 0.3 * 2.0, rel=0.1)


def test_it_feels_walls_and_its_own_wheels_are_hit_by_no_ray(rover):
    with Simulation(load_world(rover)) as sim:
        assert sim.sense("rover").proximity[4] == pytest.approx(float("inf"))
        sim.apply("rover", Command(0.5))
        bumps = []
        for _ in range(250):
            sim.step()
            bumps += sim.sense("rover").bump
        # Its nose is a flat face, 0.24 m wide and 0.2 m ahead.
        assert bumps
        assert max(map(abs, bumps)) == pytest.approx(math.atan2(0.12, 0.2), abs=0.02)
        assert sim.truth("rover").x < 3.0


def test_a_wheel_that_the_file_lacks_is_named(rover):
    (rover.parent / "tank.py").write_text(TANK.replace('"right")', '"starboard")'))
    with pytest.raises(UsageError, match="starboard"):
        Simulation(load_world(rover))


def test_a_file_without_a_base_is_told(rover):
    (rover.parent / "rover.xml").write_text(ROVER.replace('name="base"', 'name="hull"'))
    with pytest.raises(UsageError, match="no body named 'base'"):
        Simulation(load_world(rover))


def test_a_drive_of_ones_own_needs_a_body_of_ones_own():
    with pytest.raises(WorldError, match="give both drive"):
        parse_world('mjsim: 1\nrobots: [{name: r, at: [0, 0], drive: {use: "tank.py:Tank"}}]\n')
