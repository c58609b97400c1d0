"""Doors: leaves on hinges, pushed by robots, swung by events, held by locks."""

import math
from pathlib import Path

import mujoco
import numpy as np
import pytest

from mjsim.compile import compile_world, export_scene
from mjsim.errors import UsageError, WorldError
from mjsim.interface import Command
from mjsim.sim import Simulation
from mjsim.world import leaves, parse_world, segments

ROOMS = """
mjsim: 1
walls:
  - points: [[0, -3], [0, 3]]
    thickness: 0.12
    openings: [{{name: gate, segment: 0, at: 2.5, width: 1.0, door: {}}}]
robots: [{{name: r, at: [-0.8, {}], sensors: [{{lidar: scan, at: [0, 0, 0.2], beams: 3, fov_deg: 90, rate_hz: 25}}]}}]
{}
"""


def rooms(door: str = "{}", *, y: float = 0.1, more: str = "") -> Simulation:
    """Return two rooms with a door in x = 0, from y = -0.5 to y = 0.5, and a robot before it that looks along x."""
    return Simulation(parse_world(ROOMS.format(door, y, more)))


def step(sim: Simulation, seconds: float, command: Command | None = None) -> None:
    for _ in range(round(seconds / sim.dt)):
        sim.apply("r", command or Command())
        sim.step()


def degrees(sim: Simulation) -> float:
    return math.degrees(sim.door_angle("gate"))


@pytest.mark.parametrize(("hinge", "side"), [("left", -1), ("right", 1)])
@pytest.mark.parametrize("angle", [0.0, 35.0, -80.0])
def test_a_leaf_hangs_from_its_end_and_opens_to_the_left_side_of_its_wall(hinge, side, angle):
    # The wall goes north, so that its left side is west; it begins in the south.
    sim = rooms(f"{{hinge: {hinge}, angle_deg: {angle}}}")
    model, data = sim.model, sim.data
    leaf = model.geom("door/gate").id
    across = math.radians(angle)
    middle = np.array([-0.5 * math.sin(across), side * 0.5 * (1.0 - math.cos(across))])
    np.testing.assert_allclose(data.geom_xpos[leaf, :2], middle, atol=1e-9)
    assert degrees(sim) == pytest.approx(angle)


def test_a_robot_pushes_a_door_open_and_goes_through():
    sim = rooms()
    step(sim, 1.0, Command(0.4))
    assert sim.truth("r").x < -0.2
    widest = 0.0
    for _ in range(150):
        step(sim, sim.dt, Command(0.4))
        widest = min(widest, degrees(sim))
    # It came from the left side, so the leaf swings to the right one.
    assert widest < -55.0
    assert sim.truth("r").x > 1.0


def test_a_locked_door_stays_shut_whoever_pushes():
    sim = rooms("{locked: true}")
    step(sim, 4.0, Command(0.7))
    assert abs(degrees(sim)) < 0.5
    assert sim.truth("r").x + 0.22 < 0.0
    assert sim.sense("r").bump


def test_a_closer_swings_a_door_shut_again():
    sim = rooms("{angle_deg: 60, spring: 4}", y=2.0)
    step(sim, 10.0)
    assert abs(degrees(sim)) < 6.0


def test_a_leaf_turns_through_all_its_range_and_never_meets_its_own_frame():
    sim = rooms("{limit_deg: 95, locked: true}", y=2.0)
    for goal in (95.0, -95.0, 0.0):
        sim.open_door("gate", math.radians(goal))
        step(sim, 5.0)
        assert degrees(sim) == pytest.approx(goal, abs=0.3)
        assert not any("door/gate" in (sim.model.geom(g).name for g in pair) for pair in sim.data.contact.geom)


def test_a_door_is_swung_and_not_thrown_open():
    sim = rooms("{locked: true}", y=2.0)
    sim.open_door("gate", math.radians(90))
    found = [degrees(sim)]
    while found[-1] < 89.0:
        step(sim, sim.dt)
        found.append(degrees(sim))
    speeds = np.diff(found) / sim.dt
    assert speeds.max() < 70.0
    assert 1.5 < sim.time < 4.0


def test_a_door_that_closes_stops_at_what_stands_in_it_and_shuts_when_it_is_gone():
    crate = "obstacles: [{box: [0.3, 0.3, 0.4], at: [0.0, 0.3], movable: true, mass: 60, friction: 1, name: crate}]"
    sim = rooms("{angle_deg: 80, locked: true}", y=2.0, more=crate)
    sim.close_door("gate")
    step(sim, 4.0)
    # The crate reaches from y = 0.15, 0.65 m from the hinge, and to x = -0.15.
    assert degrees(sim) > math.degrees(math.atan2(0.15, 0.8)) - 2.0
    assert sim.things()["obstacle/crate"].x == pytest.approx(0.0, abs=0.02)
    sim.remove("crate")
    step(sim, 3.0)
    assert degrees(sim) == pytest.approx(0.0, abs=0.3)


def test_a_lidar_meets_the_leaf_and_looks_through_the_open_door():
    wall = "{points: [[3, -3], [3, 3]], thickness: 0.1}"
    text = ROOMS.format("{}", 0.1, "").replace("walls:", f"walls:\n  - {wall}")
    sim = Simulation(parse_world(text))
    assert sim.sense("r").scans["scan"].ranges[1] == pytest.approx(0.8 - 0.02, abs=1e-3)
    sim.open_door("gate", math.radians(-100))
    step(sim, 4.0)
    assert sim.sense("r").scans["scan"].ranges[1] == pytest.approx(0.8 + 2.95, abs=0.01)


def test_maps_show_no_leaves():
    world = parse_world(ROOMS.format("{}", 0.1, ""))
    without = parse_world(ROOMS.format("{}", 0.1, "").replace(", door: {}", ""))
    np.testing.assert_array_equal(segments(world), segments(without))


def test_a_leaf_ends_where_its_wall_does():
    text = """
mjsim: 1
walls:
  - points: [[0, 0], [4, 0]]
    height: 1.8
    openings:
      - {segment: 0, at: 3.5, width: 1, door: {}}
      - {segment: 0, at: 9, width: 1, door: {}}
      - {segment: 0, at: 1, width: 1, sill: 0.5, head: 1.2, door: {hinge: right}}
"""
    world = parse_world(text)
    first, second = leaves(world)
    assert (first.name, first.width, first.high) == ("1", 0.5, 1.8)
    assert (second.name, second.low, second.high, second.hinge) == ("3", 0.5, 1.2, (2.0, 0.0))
    compile_world(world).compile()


def test_what_cannot_be_is_told():
    sim = rooms("{limit_deg: 95}")
    with pytest.raises(UsageError, match="no door 'gat' in this world; did you mean 'gate'"):
        sim.open_door("gat")
    with pytest.raises(UsageError, match="the angle is 120 degrees; door 'gate' swings to 95 at most"):
        sim.open_door("gate", math.radians(120))
    with pytest.raises(WorldError, match="angle_deg is 100; this door swings to 90 at most"):
        rooms("{limit_deg: 90, angle_deg: 100}")
    with pytest.raises(WorldError, match="angle_deg is 150; door 'gate' swings to 110 at most"):
        rooms(more="run: {events: [{time: 1, open: gate, angle_deg: 150}]}")


def test_plain_mujoco_swings_the_leaf_and_holds_the_lock(tmp_path: Path):
    text = """
mjsim: 1
walls:
  - points: [[0, 0], [6, 0]]
    openings:
      - {name: gate, segment: 0, at: 1, width: 1, door: {angle_deg: 50}}
      - {name: vault, segment: 0, at: 4, width: 1, door: {hinge: right, angle_deg: -30, locked: true}}
lamps: [{at: [3, 2]}]
ceiling: {height: 3}
floor: {patches: [{at: [3, 3], size: [1, 1], friction: 0.2}]}
"""
    model = mujoco.MjModel.from_xml_path(str(export_scene(parse_world(text), tmp_path)))
    data = mujoco.MjData(model)
    for name in ("gate", "vault"):
        data.qfrc_applied[model.joint(f"door/{name}").dofadr[0]] = 5.0
    mujoco.mj_step(model, data, 100)
    # 5 Nm on a third of 20 kg at 1 m, for 0.4 s.
    swung = data.qpos[model.joint("door/gate").qposadr[0]] - math.radians(50)
    assert swung == pytest.approx(5.0 / (20 / 3) * 0.4**2 / 2, rel=0.15)
    assert data.qpos[model.joint("door/vault").qposadr[0]] == pytest.approx(math.radians(-30), abs=0.01)
    assert model.nlight == 3
