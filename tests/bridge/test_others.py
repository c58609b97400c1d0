"""A bridge notices other programs that publish what it publishes."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.bridge.test_bridge import namespaces_are_allowed
from tests.children import completed

pytest.importorskip("cyclonedds", reason="no wheel for Python 3.14")

WORLD = "mjsim: 1\nname: live\nrobots:\n  - {name: scout, preset: pioneer3dx, at: [1, 2]}\nrun: {rate_hz: 25}\n"
OTHER = """
import os, subprocess, sys
from mjsim.bridge import Bus, bring_loopback_up
from mjsim.ros import RELIABLE, RosTopic
TOPICS = {
    "/clock": "rosgraph_msgs/msg/Clock",
    "/scout/odom": "nav_msgs/msg/Odometry",
    "/scout/cmd_vel": "geometry_msgs/msg/Twist",
    "/tf": "tf2_msgs/msg/TFMessage",
}
if "ROS_DOMAIN_ID" not in os.environ:
    bring_loopback_up()
with Bus(domain=int(os.environ.get("ROS_DOMAIN_ID", 0))) as bus:
    for topic, kind in TOPICS.items():
        bus.announce(RosTopic(topic, kind, RELIABLE))
    code = subprocess.run([sys.executable, "-m", "mjsim.cli", "bridge", *sys.argv[1:]]).returncode
sys.exit(code)
"""

LATER = """
import os, sys, time
from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsParticipant
from mjsim.bridge import Bus
from mjsim.ros import RELIABLE, RosTopic
with Bus(domain=int(os.environ.get("ROS_DOMAIN_ID", 0))) as bus:
    bus.announce(RosTopic("/scout/odom", "nav_msgs/msg/Odometry", RELIABLE))
    print("there", flush=True)
    others = BuiltinDataReader(bus._participant, BuiltinTopicDcpsParticipant)
    while len(others.read(N=9)) < 2:
        time.sleep(0.002)
    time.sleep(0.1)
    bus.announce(RosTopic("/clock", "rosgraph_msgs/msg/Clock", RELIABLE))
    sys.stdin.read()
"""
LOOKING = """
import os, subprocess, sys
from mjsim.bridge import Bus, bring_loopback_up
if "ROS_DOMAIN_ID" not in os.environ:
    bring_loopback_up()
pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
with subprocess.Popen([sys.executable, "-c", sys.argv[1]], **pipes) as other:
    other.stdout.readline()
    with Bus(domain=int(os.environ.get("ROS_DOMAIN_ID", 0))) as bus:
        print(*sorted(bus.publishers(lambda topic: True, wait=5.0)))
    other.stdin.close()
"""


def _done(words: list[str], domain: int) -> "subprocess.CompletedProcess[str]":
    """Return what a program did on a domain where nobody else is."""
    environment = {name: value for name, value in os.environ.items() if name != "ROS_DOMAIN_ID"}
    if namespaces_are_allowed():
        words = ["unshare", "-Urn", *words]
    else:
        environment["ROS_DOMAIN_ID"] = str(10 + (os.getpid() + domain) % 90)
    return completed(words, check=False, cwd=Path(__file__).parents[2], env=environment)


@pytest.mark.slow
def test_a_topic_that_another_program_announces_a_little_later_is_found_too():
    done = _done([sys.executable, "-c", LOOKING, LATER], 23)
    assert done.stdout.split() == ["/clock", "/scout/odom"], done.stderr


@pytest.mark.slow
def test_another_simulation_on_the_domain_is_one_line(tmp_path):
    (tmp_path / "world.yaml").write_text(WORLD)
    done = _done([sys.executable, "-c", OTHER, str(tmp_path / "world.yaml")], 22)
    assert done.returncode == 2, done.stderr
    line = r"another program(, .* \d+ on .*,)? publishes /clock and 1 more topics of this world on domain \d+; stop it"
    assert re.search(line, done.stderr), done.stderr
    assert len(done.stderr.splitlines()) == 2, done.stderr
