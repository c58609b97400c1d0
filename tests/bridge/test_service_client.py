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
OK, NOT_FOUND, UNSUPPORTED_FORMAT = 1, 2, 103


@pytest.fixture(scope="module")
def answers(tmp_path_factory) -> dict:
    world = tmp_path_factory.mktemp("client") / "room.yaml"
    world.write_text(ROOM)
    words = [sys.executable, "-m", "tests.bridge.client", str(world)]
    words = ["unshare", "-Urn", *words] if namespaces_are_allowed() else [*words, str(10 + os.getpid() % 90)]
    return json.loads(completed(words, within=2 * LIMIT, cwd=Path(__file__).parents[2]).stdout)


@pytest.mark.slow
class TestAnIndependentClient:
    def test_is_told_precisely_what_can_be_spawned(self, answers):
        assert {0, 14} <= set(answers["features"])  # SPAWNING, SPAWNABLES
        assert 9 not in answers["features"]  # SPAWNING_RESOURCE_STRING
        assert answers["formats"] == []
        assert [answers[each]["result"] for each in ("text", "file")] == [UNSUPPORTED_FORMAT, NOT_FOUND]
        for each in ("text", "file"):
            assert answers[each]["error_message"].endswith(
                "by DeleteEntity or by an event at 0 s, with their names as uri"
            )
        assert "SpawnEntity brings back obstacles and beacons that were removed" in answers["info"]

    def test_spawns_what_it_deleted_at_another_pose(self, answers):
        assert answers["spawnable"] == [["crate", "anywhere on the floor"]]
        assert answers["spawned"] == {"result": OK, "error_message": "", "name": "crate"}
        assert answers["there"] == pytest.approx([1.0, -1.0, 0.6, 0.8], abs=1e-4)
        assert answers["left"] == 0

    def test_moves_steps_deletes_and_resets(self, answers):
        fine = {"result": OK, "error_message": ""}
        assert [
            answers[each] for each in ("set", "stepped", "deleted", "stepped again", "stepped thrice", "reset")
        ] == [fine] * 6
        x, y, frame, nanoseconds = answers["crate"]
        assert (x, y, frame) == (pytest.approx(3.0, abs=1e-6), pytest.approx(1.0, abs=1e-6), "map")
        assert nanoseconds == 120_000_000  # three ticks of 25 Hz after the first
        assert answers["gone"]["result"] == NOT_FOUND
        assert answers["back"] == pytest.approx([2.0, 0.0], abs=1e-6)

    def test_gets_the_documented_code_and_a_line_for_a_wrong_name(self, answers):
        assert answers["unknown"] == {"result": NOT_FOUND, "error_message": "no entity 'crat'; did you mean 'crate'?"}
