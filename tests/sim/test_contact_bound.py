"""Ticks in which robots cannot touch anything, against distances between geoms, and steps one by one."""

import math

import mujoco
import numpy as np
import pytest

from mjsim.interface import Command
from mjsim.sim import Simulation
from mjsim.sim.contact_bound import MAX_ACCELERATION, ContactBound
from mjsim.world import parse_world

ROOM = """
mjsim: 1
walls: [{points: [[0, 0], [9, 0], [9, 6]], openings: [{segment: 1, at: 2, width: 0.9, door: {}}]}]
obstacles:
  - {box: [0.5, 0.4, 0.6], at: [7, 3], heading_deg: 30}
  - {cylinder: [0.2, 0.5], at: [2, 4], movable: true, mass: 3}
robots:
  - {name: truck, preset: forklift, at: [4, 3], heading_deg: 20}
  - {name: r, at: [2, 1]}
"""
FLOOR = mujoco.mjtGeom.mjGEOM_PLANE


def nearest(sim: Simulation) -> float:
    """Return the smallest distance between a geom of a robot and one of anything else but the floor [m]."""
    model, data, least = sim.model, sim.data, 50.0
    solid = ((model.geom_contype != 0) | (model.geom_conaffinity != 0)) & (model.geom_type != FLOOR)
    roots = model.body_rootid[model.geom_bodyid]
    for name in sim.robots:
        base = model.body(f"{name}/base").id
        for own in np.flatnonzero(solid & (roots == base)):
            for other in np.flatnonzero(solid & (roots != base)):
                least = min(least, mujoco.mj_geomDistance(model, data, own, other, least, None))
    return least


def test_what_is_clear_of_robots_is_at_least_as_far_as_they_and_others_can_move():
    sim, rng, clear = Simulation(parse_world(ROOM)), np.random.default_rng(3), 0
    model, data = sim.model, sim.data
    robots = [model.body(f"{name}/base").id for name in sim.robots]
    for _ in range(8):
        for joint in range(model.njnt):
            at = model.jnt_qposadr[joint]
            if model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_HINGE:
                data.qpos[at] = rng.uniform(-3, 3)
            else:
                data.qpos[at : at + 2] = rng.uniform(-9, 9, 2)
                heading = rng.uniform(-3, 3)
                data.qpos[at + 3 : at + 7] = [math.cos(heading / 2), 0, 0, math.sin(heading / 2)]
        mujoco.mj_forward(model, data)
        dt = 0.02
        around = ContactBound(model, data, robots, model.geom_type == FLOOR, dt=dt)
        if around.are_clear():
            clear += 1
            assert nearest(sim) > MAX_ACCELERATION * dt**2
            # As fast as would bring the nearest things into contact.
            data.qvel[model.joint("r/free").dofadr[0]] = nearest(sim) / dt
            assert not around.are_clear()
            data.qvel[:] = 0.0
    assert clear > 2


def test_robots_that_approach_each_other_are_not_clear_when_they_touch():
    # Both move: their distance shrinks by more than the norm of all motion.
    text = "mjsim: 1\nrobots: [{name: one, at: [0, 0]}, {name: two, at: [4, 0], heading_deg: 180}]\n"
    sim = Simulation(parse_world(text))
    model, data = sim.model, sim.data
    robots = [model.body(f"{name}/base").id for name in sim.robots]
    around = ContactBound(model, data, robots, model.geom_type == FLOOR, dt=0.02)
    assert around.are_clear()
    one, two = (model.jnt_qposadr[model.joint(f"{name}/free").id] for name in sim.robots)
    for step in range(1, 20):
        data.qpos[one], data.qpos[two] = 0.1 * step, 4.0 - 0.1 * step
        mujoco.mj_forward(model, data)
        if not around.are_clear():
            break
        assert nearest(sim) > 0.0
    assert 10 < step < 19


@pytest.mark.parametrize(("speed", "off"), [(6.0, 0.38), (-5.0, 0.1)])
def test_contacts_of_a_thrown_thing_are_those_of_steps_one_by_one(speed, off):
    # An inertial sensor measures at each step of the physics.
    found = []
    for sensors in ("[]", "[{imu: imu, rate_hz: 250}]"):
        text = f"""
mjsim: 1
obstacles: [{{cylinder: [0.2, 0.5], at: [{-2 * math.copysign(1, speed)}, {off}], movable: true, mass: 1}}]
robots: [{{name: r, at: [0, 0], sensors: {sensors}}}]
"""
        sim = Simulation(parse_world(text))
        sim.data.qvel[0] = speed
        bumps = []
        for _ in range(15):
            sim.apply("r", Command(0.2))
            sim.step()
            bumps.append((sim.sense("r").bump, sim.data.qpos.tobytes()))
        found.append(bumps)
    assert any(bump for bump, _ in found[0])
    assert found[0] == found[1]


@pytest.mark.parametrize("is_shoved", [False, True])
def test_no_contact_between_ticks_is_missed_where_robots_are_said_to_touch_nothing(is_shoved, monkeypatch):
    thing = "obstacles: [{name: thing, cylinder: [0.2, 0.5], at: [-1, 0.2], movable: true, mass: 1}]"
    found = []
    for always in (False, True):
        if always:
            monkeypatch.setattr(ContactBound, "are_clear", lambda self: False)
        sim = Simulation(parse_world(f"mjsim: 1\n{thing}\nrobots: [{{name: r, at: [0, 0]}}]\n"))
        if is_shoved:
            sim.shove("thing", (40.0, 0.0, 0.0), 0.004)
        else:
            sim.data.qvel[sim.model.joint("obstacle/thing").dofadr[0]] = 40.0
        bumps = []
        for _ in range(6):
            sim.step()
            bumps.append(sim.sense("r").bump)
        found.append(bumps)
    assert any(found[1])
    assert found[0] == found[1]
