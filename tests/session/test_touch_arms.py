"""Arms that are led in a session become events of the world file, in degrees and metres."""

import math

import numpy as np
import pytest

from mjsim.errors import UsageError
from mjsim.mechanics import rpy_of
from mjsim.session import Session
from mjsim.world import parse_world

WORLD = parse_world("mjsim: 1\nrobots: [{name: r, base: fixed, at: [1, 2], arms: [{preset: puma560}]}]\n")


@pytest.fixture(scope="module")
def session():
    session = Session(WORLD, seed=7, seconds=1000.0, speed=1.0)
    session.start(paused=True)
    session.wait("paused", timeout=10.0)
    yield session
    session.close()


def test_joints_and_tools_are_touches_in_degrees(session):
    session.move_joints("r", "arm", [0.1, -0.2, 0.3, 0.0, 0.5, 0.0])
    pose = WORLD.robots[0].arms[0].arm.fkine(np.array([0.2, -0.3, 0.4, 0.1, 0.6, 0.2]))
    session.move_tool("r", "arm", at=pose[:3, 3].tolist(), rpy=rpy_of(pose))
    session.move_joints("r", "arm", None)
    joints, tool, release = session.touched[-3:]
    assert joints.joints_deg == pytest.approx([math.degrees(q) for q in (0.1, -0.2, 0.3, 0.0, 0.5, 0.0)], abs=1e-2)
    assert tool.tool == pytest.approx(tuple(pose[:3, 3]), abs=1e-3)
    assert tool.rpy_deg == pytest.approx(tuple(np.degrees(rpy_of(pose))), abs=2e-2)
    assert release.release == "r"
    for positions in ([0.1], [math.nan] * 6, [0.1] * 7):
        with pytest.raises(UsageError, match="arm 'arm' has 6 joints; give as many finite numbers"):
            session.move_joints("r", "arm", positions)
    with pytest.raises(UsageError, match="no arm"):
        session.move_joints("r", "arn", None)
    with pytest.raises(UsageError):
        session.move_tool("r", "arm", at=[5.0, 0.0, 0.0], rpy=[0.0, 0.0, 0.0])


def test_a_restart_keeps_its_seed_unless_another_is_given(session):
    assert session.seed == 7
    session.restart()
    assert session.seed == 7
    session.restart(seed=9)
    assert session.seed == 9
