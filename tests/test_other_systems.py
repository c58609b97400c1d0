"""A run needs nothing that exists on Unix alone: macOS and Windows are untried, not impossible."""

import os
import sys
from pathlib import Path

import pytest

from tests.children import completed

ROOT = Path(__file__).parent.parent
HIDDEN = """
import os, signal, subprocess, sys, sysconfig

UNIX = {"fcntl", "grp", "posix_spawn", "pty", "pwd", "readline", "resource", "syslog", "termios", "tty"}
EVERYWHERE = {"SIGABRT", "SIGFPE", "SIGILL", "SIGINT", "SIGSEGV", "SIGTERM", "SIG_DFL", "SIG_IGN"}
CALLS = (
    "O_CLOEXEC O_DIRECTORY O_NOFOLLOW O_NONBLOCK O_PATH P_PID chown fchown fork forkpty getegid geteuid getgid getpgid"
    " getuid killpg lchown mkfifo posix_spawn posix_spawnp sched_getaffinity setpgid setsid sysconf wait3 wait4 waitid"
).split()


class Hide:
    @staticmethod
    def find_spec(name, path=None, target=None):
        if name in UNIX:
            raise ModuleNotFoundError(f"No module named '{name}'", name=name)


for name in UNIX:
    sys.modules.pop(name, None)
sys.meta_path.insert(0, Hide)
for name in [name for name in vars(signal) if name.startswith("SIG") and name.isupper() and name not in EVERYWHERE]:
    delattr(signal, name)
for name in CALLS:
    delattr(os, name)
# As on Windows, where it needs no signal.
subprocess.Popen.kill = lambda process: process.send_signal(9)
sysconfig.get_config_vars()  # Python does not know itself by this name.
sys.platform = "other"
"""
ROOM = """
beacons: [{name: lion, image: posters/lion.jpg, at: [3, 0], heading_deg: 180, width: 0.8}]
robots: [{name: scout, at: [0, 0], sensors: [{camera: front, at: [0.1, 0, 0.5], width: 64, height: 48, rate_hz: 5}]}]
"""


@pytest.mark.slow
def test_a_camera_runs_where_there_is_nothing_of_unix_and_says_once_that_readers_have_no_limits(tmp_path):
    # A picture of a stranger is read in a child, in which this system is the same.
    (tmp_path / "sitecustomize.py").write_text(HIDDEN)
    (tmp_path / "room.yaml").write_text(ROOM)
    (tmp_path / "posters").mkdir()
    (tmp_path / "posters" / "lion.jpg").write_bytes((ROOT / "assets" / "posters" / "lion.jpg").read_bytes() + bytes(1))
    environment = {**os.environ, "PYTHONPATH": str(tmp_path), "XDG_CACHE_HOME": str(tmp_path)}
    words = [Path(sys.executable).with_name("mjsim"), "run", "room.yaml", "--seconds", "0.4", "-o", "run.mcap"]
    done = completed(words, env=environment, cwd=tmp_path)
    assert (tmp_path / "run.mcap").stat().st_size > 10_000
    assert done.stderr.count("files are read with fewer limits here: none on memory, other files, network") == 1
