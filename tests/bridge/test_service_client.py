"""Services of `simulation_interfaces`, called over DDS by a client that shares neither types nor CDR with mjsim."""

import json
import os
import sys
from pathlib import Path

import pytest

from tests.bridge.test_bridge import namespaces_are_allowed
from tests.children import LIMIT, completed

pytest.importorskip("cyclonedds", reason="no wheel for Python 3.14")

ROOM = """
mjsim: 1
obstacles: [{name: crate, box: [0.3, 0.3, 0.4], at: [2, 0], movable: true, mass: 2}]
robots: [{name: scout, preset: pioneer3dx, at: [0, 0]}]
"""
UNSUPPORTED, OK, NOT_FOUND = range(3)


@pytest.fixture(scope="module")
def answers(tmp_path_factory) -> dict:
    world = tmp_path_factory.mktemp("client") / "room.yaml"
    world.write_text(ROOM)
    words = [sys.executable, "-m", "tests.bridge.client", str(world)]
    words = ["unshare", "-Urn", *words] if namespaces_are_allowed() else [*words, str(10 + os.getpid() % 90)]
    return json.loads(completed(words, within=2 * LIMIT, cwd=Path(__file__).parents[2]).stdout)


@pytest.mark.slow
class TestAnIndependentClient:
    def test_is_told_precisely_that_nothing_can_be_spawned(self, answers):
        assert 0 not in answers["features"]  # SPAWNING
        assert answers["formats"] == []
        assert answers["spawn"]["result"] == UNSUPPORTED
        assert answers["spawn"]["error_message"] in answers["info"]

    def test_moves_steps_deletes_and_resets(self, answers):
        fine = {"result": OK, "error_message": ""}
        assert [answers[each] for each in ("set", "stepped", "deleted", "stepped again", "reset")] == [fine] * 5
        x, y, frame, nanoseconds = answers["crate"]
        assert (x, y, frame) == (pytest.approx(3.0, abs=1e-6), pytest.approx(1.0, abs=1e-6), "map")
        assert nanoseconds == 120_000_000  # three ticks of 25 Hz after the first
        assert answers["gone"]["result"] == NOT_FOUND
        assert answers["back"] == pytest.approx([2.0, 0.0], abs=1e-6)

    def test_gets_the_documented_code_and_a_line_for_a_wrong_name(self, answers):
        assert answers["unknown"] == {"result": NOT_FOUND, "error_message": "no entity 'crat'; did you mean 'crate'?"}
