"""`mjsim bridge --private`: nobody outside its network finds the robots; who joins it does."""

import signal
import sys
from pathlib import Path

import pytest

from tests.bridge.test_bridge import WORLD, namespaces_are_allowed
from tests.children import LIMIT, child, completed

pytest.importorskip("cyclonedds", reason="no wheel for Python 3.14")
pytestmark = pytest.mark.slow

LOOK = """
import sys, time, rosless
node, until = rosless.Node(domain=0), time.monotonic() + float(sys.argv[1])
names = []
while "/scout/scan" not in names and time.monotonic() < until:
    time.sleep(0.2)
    names = [topic.name for topic in node.graph().topics]
print(*names)
"""


def seen(*prefix: str, seconds: int) -> str:
    """Return the topics that an independent ROS 2 node discovers within a time."""
    return completed([*prefix, sys.executable, "-c", LOOK, str(seconds)], within=2 * LIMIT).stdout


@pytest.mark.skipif(not namespaces_are_allowed(), reason="asks Linux with namespaces for users")
def test_only_who_joins_the_private_network_finds_the_robot(tmp_path: Path):
    (tmp_path / "room.yaml").write_text(WORLD)
    words = [sys.executable, "-m", "mjsim.cli", "bridge", str(tmp_path / "room.yaml"), "--private"]
    with child(words) as bridge:
        said = bridge.line("stderr")
        join = said.split("to join it: ")[1].split(" COMMAND")[0].split()
        assert join[-1] == str(bridge.pid)
        assert "/scout/scan" in seen(*join, seconds=60)
        # Discovery took well under this time inside.
        assert "/scout/scan" not in seen(seconds=5)
        # What it writes belongs to its user, who is mapped to the same number.
        inside, outside, count = Path(f"/proc/{bridge.pid}/uid_map").read_text().split()
        assert (inside, count) == (outside, "1")
        bridge.send(signal.SIGINT)
        assert bridge.ended() == 130


def test_what_stands_in_the_way_is_said_in_one_line(tmp_path: Path):
    (tmp_path / "room.yaml").write_text(WORLD)
    words = [sys.executable, "-m", "mjsim.cli", "bridge", str(tmp_path / "room.yaml"), "--private"]
    done = completed([*words, "--interface", "lo"], check=False)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "leave out --interface or --private" in done.stderr
    late = "import threading, time; threading.Thread(target=time.sleep, args=[1]).start()\n"
    late += "from mjsim.bridge import enter_private_network; enter_private_network()"
    done = completed([sys.executable, "-c", late], check=False)
    assert "UsageError: no private network on this system: [Errno" in done.stderr
