"""Floor patches: other friction under a wheel, other looks, and nothing in a robot's way."""

import mujoco
import numpy as np
import pytest

from mjsim.bench.rooms import forwarded, look_from
from mjsim.compile import compile_world
from mjsim.compile.room.floor import layers
from mjsim.interface import Command
from mjsim.sim import Renderer, Simulation
from mjsim.world import parse_world

GRAVITY = 9.81


def drive(text: str, *, until: float) -> Simulation:
    """Return a robot that has driven along x at 1 m/s, 250 ticks a second."""
    sim = Simulation(parse_world(text))
    sim.apply("r", Command(1.0))
    while sim.truth("r").x < until:
        sim.step()
    return sim


@pytest.mark.parametrize("friction", [0.05, 0.2])
def test_a_robot_that_brakes_on_ice_slides_as_far_as_friction_lets_it(friction):
    sim = drive(
        f"""
mjsim: 1
floor: {{patches: [{{at: [5.5, 0], size: [10, 2], friction: {friction}}}]}}
robots: [{{name: r, at: [0, 0], drive: {{max_speed: 1.0, max_acceleration: 8.0}}}}]
run: {{rate_hz: 250}}
""",
        until=3.0 if friction < 0.1 else 1.5,
    )
    braked, speed, before = sim.truth("r").x, sim.data.qvel[0], sim.truth("r").x - sim.dt
    sim.apply("r", Command())
    while sim.truth("r").x > before + 1e-5:
        before = sim.truth("r").x
        sim.step()
    ideal = speed**2 / (2 * friction * GRAVITY)
    # The casters, which slide freely, carry a tenth; the wheels also need 30 ms until they are locked.
    assert ideal < sim.truth("r").x - braked < 1.12 * ideal + 0.03 * speed


def test_a_robot_on_the_plain_floor_beside_the_ice_brakes_as_ever():
    text = "mjsim: 1\nfloor: {{patches: {}}}\nrobots: [{{name: r, at: [0, 0]}}]\n"
    places = []
    for patches in ("[]", "[{at: [0, 3], size: [9, 2], friction: 0.05}]"):
        sim = Simulation(parse_world(text.format(patches)))
        for command in [Command(0.5)] * 40 + [Command()] * 20:
            sim.apply("r", command)
            sim.step()
        places.append(sim.truth("r"))
    assert places[0] == places[1]


@pytest.mark.slow
def test_the_edge_of_a_patch_is_no_bump_and_turns_nobody_aside():
    sim = drive(
        """
mjsim: 1
floor: {patches: [{at: [2, 0.1], size: [2, 0.5], heading_deg: 30}]}
robots: [{name: r, at: [0, 0], drive: {max_speed: 1.0}}]
run: {rate_hz: 250}
""",
        until=0.4,
    )
    seconds = 0.0
    while sim.truth("r").x < 3.4:
        assert sim.sense("r").bump == ()
        sim.step()
        seconds += sim.dt
    assert seconds == pytest.approx(3.0, rel=0.01)
    assert abs(sim.truth("r").y) < 0.01


def test_a_patch_lies_on_those_before_it_that_it_covers():
    patches = parse_world(
        """
mjsim: 1
floor:
  patches:
    - {at: [0, 0], size: [2, 2]}
    - {at: [5, 0], size: [2, 2]}
    - {at: [0.5, 0], size: [2, 1], heading_deg: 45}
    - {at: [2.7, 0], size: [4, 0.2]}
"""
    ).floor.patches
    assert layers(patches) == [1, 1, 2, 3]


def test_a_patch_is_seen_in_its_colour_where_it_lies():
    model = compile_world(
        parse_world(
            """
mjsim: 1
floor:
  color: "#000000"
  patches: [{at: [0, 0], size: [2, 1], heading_deg: 90, color: "#00ff00", name: lawn}]
"""
        )
    ).compile()
    data = forwarded(model)
    look_from(model, data, "overview", [0.0, 0.0, 3.0], [0.0, 0.0, -1.0])
    fovy = np.radians(model.cam_fovy[model.camera("overview").id])
    with Renderer(model, width=200, height=200) as renderer:
        green = renderer.render(data, "overview")[..., 1] > 120
    metre = 100 / np.tan(fovy / 2) / 3.0
    rows, columns = np.nonzero(green)
    # It is seen from its layer, half a millimetre nearer; a pixel more or less at each side.
    assert np.ptp(columns) + 1 == pytest.approx(metre * 1.0, abs=2)
    assert np.ptp(rows) + 1 == pytest.approx(metre * 2.0, abs=2)
    assert mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_GEOM, "floor/lawn") >= 0
