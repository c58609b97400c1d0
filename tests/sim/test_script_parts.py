"""What events do to the physics, without the loop: impulses, placed bodies, movers on their routes."""

import math

import mujoco
import numpy as np
import pytest

from mjsim.mechanics import Ramp
from mjsim.sim import Simulation
from mjsim.sim.script.mover_motion import Movers
from mjsim.sim.script.placing import heading_of, held_by, put_down
from mjsim.sim.script.shoves import Shoves
from mjsim.world import parse_world

WORLD = """
mjsim: 1
walls: [{name: north, points: [[-5, 3], [5, 3]]}, {points: [[-5, -3], [5, -3]]}]
obstacles:
  - {name: crate, box: [0.4, 0.4, 0.4], at: [3, 0], movable: true, mass: 5}
  - {name: cart, box: [0.3, 0.3, 0.3], at: [-3, 0], path: {points: [[-3, 2], [-1, 2]], speed: 0.5}}
robots: [{name: r, at: [0, 0], heading_deg: 40}, {name: q, at: [0, -2]}]
"""


@pytest.fixture(scope="module")
def sim():
    with Simulation(parse_world(WORLD)) as sim:
        yield sim


def pushed(shoves, data, body, step):
    """Return the force on a body in each step until no shove acts, shape (steps, 3) [N]."""
    forces = []
    while shoves and len(forces) < 100:
        shoves.push()
        forces.append(data.xfrc_applied[body, :3].copy())
    return np.array(forces)


@pytest.mark.parametrize(("seconds", "steps"), [(0.02, 5), (0.0, 1), (0.0301, 8)])
def test_a_shove_gives_exactly_its_impulse_in_its_time_and_nothing_after(sim, seconds, steps):
    shoves, body, step = Shoves(sim.model, sim.data), sim.model.body("r/base").id, sim.model.opt.timestep
    assert not shoves
    shoves.add("r/base", [1.0, -2.0, 3.0], seconds)
    forces = pushed(shoves, sim.data, body, step)
    np.testing.assert_allclose(forces.sum(axis=0) * step, [1.0, -2.0, 3.0])
    assert np.count_nonzero(forces.any(axis=1)) == steps
    np.testing.assert_array_equal(forces[-1], 0.0)


def test_shoves_add_up_and_a_signal_has_its_own_time(sim):
    shoves, body, step = Shoves(sim.model, sim.data), sim.model.body("r/base").id, sim.model.opt.timestep
    shoves.add("r/base", [1.0, 0.0, 0.0], 0.02)
    shoves.push()
    shoves.push_along("r/base", Ramp(before=0.0, slope=100.0, start=0.0, seconds=9.0), [0.0, 1.0, 0.0], seconds=0.012)
    forces = pushed(shoves, sim.data, body, step)
    np.testing.assert_allclose(forces[:, 0] * step, [0.2] * 4 + [0.0])
    np.testing.assert_allclose(forces[:, 1], [0.0, 100 * step, 200 * step, 0.0, 0.0], atol=1e-12)


def test_what_is_put_down_is_at_rest_at_its_place_with_its_wheels_as_they_were(sim):
    data, free = sim.data, sim.model.joint("r/free")
    place, wheel = int(free.qposadr[0]), int(sim.model.joint("r/wheel_left").qposadr[0])
    before, other = sim.model.qpos0.copy(), sim.model.joint("q/free").dofadr[0]
    for heading, told in ((None, math.radians(40)), (-2.0, -2.0)):
        data.qpos[:], data.qvel[:] = before, 1.0
        data.qpos[wheel] = 0.7
        parts = put_down(sim.model, data, "r/free", (1.5, -0.5), height=None, heading=heading)
        root = sim.model.body("r/base").id
        assert parts.tolist() == np.flatnonzero(sim.model.body_rootid[sim.model.geom_bodyid] == root).tolist()
        mujoco.mj_kinematics(sim.model, data)
        body = data.body("r/base")
        np.testing.assert_allclose(body.xpos, [1.5, -0.5, before[place + 2]])
        assert heading_of(body.xmat) == pytest.approx(told)
        assert data.qpos[wheel] == 0.7
        own = sim.model.body_rootid[sim.model.dof_bodyid] == root
        np.testing.assert_array_equal(data.qvel[own], 0.0)
        assert data.qvel[other] == 1.0, "others go on"
    put_down(sim.model, data, "r/free", (0.0, 0.0), height=1.25, heading=0.0)
    assert data.qpos[place + 2] == 1.25
    data.qpos[:], data.qvel[:] = before, 0.0
    mujoco.mj_forward(sim.model, data)


@pytest.mark.parametrize(
    ("at", "told"),
    [
        ((0.0, 3.0), "wall 'north'"),
        ((0.0, -3.0), "walls[1]"),
        ((3.0, 0.0), "obstacle 'crate'"),
        ((0.1, -2.0), "'q'"),
        ((1.5, 1.0), None),
    ],
)
def test_where_there_is_no_room_is_told_by_what_stands_there(sim, at, told):
    before = sim.data.qpos.copy()
    own = put_down(sim.model, sim.data, "r/free", at, height=None, heading=None)
    mujoco.mj_forward(sim.model, sim.data)
    assert held_by(sim.model, sim.data, own) == told
    if told == "'q'":
        assert held_by(sim.model, sim.data, own, but=[sim.model.body("q/base").id]) is None
    sim.data.qpos[:] = before
    mujoco.mj_forward(sim.model, sim.data)


def test_a_mover_is_on_its_route_with_the_speed_of_its_way(sim):
    movers, body, h = Movers(sim.model, sim.data, sim.world), sim.data.body("obstacle/cart"), 1e-4
    assert len(movers) == 1
    for time, place in ((0.0, (-3.0, 0.0)), (2.0, (-3.0, 1.0)), (5.0, (-2.5, 2.0)), (6.0, (-2.0, 2.0))):
        movers.put(time)
        mujoco.mj_kinematics(sim.model, sim.data)
        np.testing.assert_allclose(body.xpos[:2], place, atol=1e-9)
    movers.put(3.0 + h)
    ahead, speed = sim.data.qpos.copy(), sim.data.qvel.copy()
    movers.put(3.0 - h)
    slides = [sim.model.joint(f"obstacle/cart/{axis}") for axis in "xy"]
    for slide in slides:
        slope = (ahead - sim.data.qpos)[slide.qposadr[0]] / (2 * h)
        assert speed[slide.dofadr[0]] == pytest.approx(slope, abs=1e-6)
    assert speed[slides[1].dofadr[0]] == pytest.approx(0.5)
