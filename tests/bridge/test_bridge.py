"""`mjsim bridge` against rosless (RustDDS), an implementation of ROS 2 that shares no line with it, both ways."""

import json
import math
import os
import sys
from pathlib import Path

import numpy as np
import pytest
from rosbags.highlevel import AnyReader

import mjsim
from mjsim.datasets import export_rosbag2
from tests.bridge.peer import TOPICS
from tests.children import LIMIT, completed

pytest.importorskip("cyclonedds", reason="no wheel for Python 3.14")

WORLD = """mjsim: 1
name: live
walls: [{points: [[0, 0], [6, 0], [6, 4], [0, 4]], closed: true}]
beacons: [{name: a, at: [5.9, 2], heading_deg: 180}, {name: b, at: [3, 3.9], heading_deg: -90}]
robots:
  - name: scout
    preset: pioneer3dx
    at: [1, 2]
    sensors:
      - {lidar: scan, beams: 90, rate_hz: 12.5, noise: {range: 0.01}}
      - {imu: imu, rate_hz: 50}
      - {camera: front, at: [0.1, 0, 0.5], width: 32, height: 24, rate_hz: 5, depth: true}
      - {beacons: ring, rate_hz: 5}
mechanisms:
  - name: crank
    at: [5, 3.5]
    elevation: 1
    bodies: [{name: bar, rod: [0.3, 0.02]}]
    joints: [{revolute: q, of: [ground, bar], axis: [0, 1, 0]}]
run:
  rate_hz: 25
  seed: 4
  drivers:
    scout:
      estimator: {use: "mjsim.algorithms.ekf_slam:EkfSlam"}
      navigator: {use: "mjsim.algorithms.go_to_goal:GoToGoal", goals: [1, 2]}
"""


def namespaces_are_allowed() -> bool:
    return completed(["unshare", "-Urn", "true"], check=False).returncode == 0


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a run that was driven over the bus, with what was heard of it."""
    folder = tmp_path_factory.mktemp("bridge")
    (folder / "world.yaml").write_text(WORLD)
    words = [sys.executable, "-m", "tests.bridge.peer", str(folder)]
    if namespaces_are_allowed():
        words = ["unshare", "-Urn", *words]
    else:
        words += [str(10 + os.getpid() % 90)]  # a domain that nobody else is likely to use
    completed(words, within=4 * LIMIT, cwd=Path(__file__).parents[2])
    return folder


@pytest.fixture(scope="module")
def noticed(folder: Path) -> dict:
    return json.loads((folder / "noticed.json").read_text())


def plain(value: object) -> object:
    """Return a message of rosbags as numbers, texts, lists and dicts."""
    if hasattr(value, "__dataclass_fields__"):
        return {name: plain(getattr(value, name)) for name in value.__dataclass_fields__ if name != "__msgtype__"}
    if isinstance(value, np.ndarray):
        return value.tolist()
    return [plain(each) for each in value] if isinstance(value, list) else value


@pytest.mark.slow
class TestABridge:
    def test_every_field_of_every_message_arrives_and_none_is_lost(self, folder: Path, noticed: dict):
        heard = json.loads((folder / "heard.json").read_text())
        sent: dict[str, list] = {topic: [] for topic in TOPICS}
        bag = export_rosbag2(mjsim.read_recording(folder / "run.mcap"), folder / "bag", redraw=True)
        with AnyReader([bag]) as reader:
            for connection, _, raw in reader.messages():
                if connection.topic in sent:
                    sent[connection.topic].append(plain(reader.deserialize(raw, connection.msgtype)))
        # rosless has no negative int8: unknown cells, -1, come as 255.
        sent["/map"][0]["data"] = [cell % 256 for cell in sent["/map"][0]["data"]]
        for topic, messages in heard.items():
            # From the first that came, when it was discovered, to the end.
            expected = sent[topic][len(sent[topic]) - len(messages) :]
            wrong = [row for row, both in enumerate(zip(messages, expected, strict=True)) if both[0] != both[1]]
            assert not wrong, f"{topic}: messages {wrong[:5]} of {len(messages)} differ"
        counts = {topic: len(messages) for topic, messages in heard.items()}
        assert counts["/clock"] > 100
        assert counts["/scout/scan"] > 50
        assert min(counts["/scout/front/image_raw"], counts["/scout/front/depth/image_raw"]) > 20
        assert counts["/tf_static"] == counts["/map"] == 1
        sys.stdout.write(f"a step to its clock on the bus: {1e3 * noticed['step_to_clock_s']:.1f} ms; {counts}\n")

    def test_commands_move_the_robot_until_they_stop(self, noticed: dict):
        assert noticed["twist"] == pytest.approx(0.3, abs=0.02)
        assert noticed["stamped"] == pytest.approx(-0.3, abs=0.02)
        moved, halted, later = noticed["places"]
        assert 0.15 < halted[0] - moved[0] < 0.24  # half a second, then it brakes
        assert math.dist(halted, later) < 1e-4

    def test_services_pause_step_and_reset(self, noticed: dict):
        assert noticed["paused"].startswith("paused at ")
        assert noticed["stepped"].startswith("paused at ")
        assert noticed["reset"] == "paused at 0 s"
        assert noticed["reset_running"].startswith("running at ")

    def test_services_of_simulation_interfaces_step_and_tell_where_the_robot_is(self, noticed: dict):
        assert 32 in noticed["features"]
        told, heard = noticed["states"]
        assert told == pytest.approx(heard, abs=1e-9)

    def test_a_goal_pose_reaches_the_navigator_if_it_is_in_the_map(self, folder: Path):
        events = mjsim.read_recording(folder / "run.mcap").events
        assert {(event.goal, event.to, event.heading_deg) for event in events} == {("scout", (5.0, 2.0), 180.0)}

    def test_others_see_the_topics(self, noticed: dict):
        assert {*TOPICS, "/scout/cmd_vel", "/scout/proximity"} <= {*noticed["graph"]}

    def test_ctrl_c_ends_it_with_a_whole_recording(self, folder: Path, noticed: dict):
        assert noticed["code"] == 130
        assert mjsim.read_recording(folder / "run.mcap").whole
        assert mjsim.read_recording(folder / "run-2.mcap").time[0] == 0.0
