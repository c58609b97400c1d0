"""The limits of each test, and who watches over them: pytest-timeout within its process, a watchdog outside of it."""

import faulthandler
import mmap
import os
import signal
import struct
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from types import FrameType

import pytest

from tests.watchdog import offspring

BROWSER = 60.0
"""Limit of a test with a browser [s]; that of most others is in pyproject.toml."""
WHOLE = 120.0
"""Limit of a test of the files below [s]."""
LONG = {
    "algorithms/test_errors_in_common.py",
    "algorithms/test_lidar_slam.py",
    "algorithms/test_slam_rooms.py",
    "bridge/test_bridge.py",
    "bridge/test_private.py",
    "datasets/test_slam_clients.py",
    "exchange/test_odometry_of_robots.py",
    "experiments/test_experiments.py",
    "sweep/test_sweep.py",
    "test_setup.py",
    "test_watchdog.py",
    "web/test_first_slam_page.py",
    "world/test_large_world.py",
    "worlds/test_balancing_run.py",
    "worlds/test_gallery_run.py",
    "worlds/test_matlab_world.py",
}
"""Files with a test of over 5 s of processor time, or one that starts large programs."""
LOADED = 300.0
"""What a test may take beyond its limit while it computes, on a machine that does other things [s]."""
WINDOW = 5.0
IDLE = 0.1
"""Who used less processor time than this in the last window before the limit waits for what does not come [s]."""
GRACE = 60.0
"""What a test and what it set up may take to end, once its limit within the process is over [s]."""
COLLECTION = 300.0
"""[s]"""
END = 60.0
"""What a process may take to end after its last test [s]."""
LONGEST = (
    "worlds/test_shipped_worlds.py",
    "algorithms/test_slam_rooms.py",
    "test_tutorials.py",
    "worlds/test_gallery_run.py",
    "web/test_studio_disk_page.py",
    "cli/test_overwrite.py",
    "sweep/test_sweep.py",
    "web/test_axe_page.py",
    "algorithms/test_recovery.py",
    "exchange/test_robot_drives.py",
    "web/test_studio_unsaved_page.py",
    "sim/test_balancing_modules.py",
    "web/test_lead_joints_page.py",
    "session/test_touch_mechanism.py",
    "run/test_modules_run.py",
    "web/test_lead_loops_page.py",
    "web/test_studio_run_page.py",
    "algorithms/test_navigators.py",
    "sim/test_drives_presets.py",
    "web/test_studio_newcomer.py",
    "web/test_connections.py",
    "safety/test_avoidance.py",
    "test_docs.py",
    "web/test_studio_saving.py",
    "test_watchdog.py",
    "record/test_record_bounds.py",
    "web/test_gone_page.py",
    "web/test_lead_arm_page.py",
    "web/test_studio_touch_page.py",
    "web/test_studio_edit_page.py",
    "modules/test_programs.py",
    "modules/test_octave_mistakes.py",
    "algorithms/test_lidar_slam.py",
    "web/test_studio_pose_page.py",
    "world/test_large_world.py",
    "web/test_lead_person_page.py",
)
"""Files of 15 s and more in a whole run, which begin first; `--durations` tells which."""
IGNORED_AT_START = (signal.SIGPIPE, signal.SIGXFSZ)
"""What Python itself ignores; it has the defaults in the programs that it starts."""


class Watchdog:
    """A program beside this process, which ends it when something takes too long.

    What is done is told in memory that both share: a message for each test would wake the program 13,000 times.
    """

    def __init__(self) -> None:
        with tempfile.TemporaryFile() as shared:
            shared.truncate(mmap.PAGESIZE)
            self._told = mmap.mmap(shared.fileno(), mmap.PAGESIZE)
            words = [sys.executable, "-S", "-E", Path(__file__).with_name("watchdog.py"), os.getpid(), shared.fileno()]
            pipes = {"stdin": subprocess.PIPE, "pass_fds": [shared.fileno()]}
            self._program = subprocess.Popen(list(map(str, words)), start_new_session=True, **pipes)

    def expect(self, what: str, seconds: float) -> None:
        """Tell what is done from now on, and how long that may take at most; 0 for ever."""
        ends = time.monotonic() + seconds if seconds else 0.0
        struct.pack_into("d", self._told, 0, 0.0)  # until all is told
        struct.pack_into("d256p", self._told, 8, seconds, what.encode())
        struct.pack_into("d", self._told, 0, ends)


class Patience:
    """The limit of one test: in processor time, and by the clock for one that waits and computes nothing."""

    def __init__(self, limit: float, fail: Callable[[int, FrameType | None], object]) -> None:
        self._limit, self._fail = limit, fail
        self._began, self._own, self._others, self._before = time.monotonic(), _own_time(), -1.0, 0.0

    def first(self) -> float:
        """Return when it has to look first, from now [s]."""
        return max(self._limit - WINDOW, 0.5 * self._limit)

    def look(self, number: int, frame: FrameType | None) -> None:
        """End the test if its time is over, else look again later; a handler of signals."""
        took, others = time.monotonic() - self._began, _time_of_others()
        if self._others < 0.0:
            self._others = others  # to look through all processes before each test would cost more than most tests
        used = _own_time() - self._own + others - self._others
        idle = used - self._before < IDLE
        if took >= self._limit and (idle or used >= self._limit or took >= self._limit + LOADED):
            self._fail(number, frame)
        self._before = used
        signal.setitimer(
            signal.ITIMER_REAL, min(WINDOW, max(self._limit - took, 0.1)) if took < self._limit else WINDOW
        )


def _own_time() -> float:
    """Return the processor time of this process, and of all that it started and that has ended [s]."""
    return sum(os.times()[:4])


def _time_of_others() -> float:
    """Return the processor time of all that this process started and that goes on [s]."""
    ticks = 0
    for each in offspring(os.getpid()):
        try:
            ticks += sum(map(int, Path(f"/proc/{each}/stat").read_text().rpartition(")")[2].split()[11:15]))
        except OSError:
            continue  # It has ended.
    return ticks / os.sysconf("SC_CLK_TCK")


class Watch:
    """What pytest does, told to the watchdog."""

    def __init__(self) -> None:
        self._watchdog = Watchdog()

    @pytest.hookimpl(wrapper=True)
    def pytest_collection(self):
        self._watchdog.expect("the collection", COLLECTION)
        try:
            return (yield)
        finally:
            self._watchdog.expect("", 0.0)

    @pytest.hookimpl(wrapper=True)
    def pytest_timeout_set_timer(self, item, settings):
        self._watchdog.expect(item.nodeid, settings.timeout + LOADED + GRACE)
        is_set = yield
        if settings.method == "signal":
            patience = Patience(settings.timeout, signal.getsignal(signal.SIGALRM))
            signal.signal(signal.SIGALRM, patience.look)
            signal.setitimer(signal.ITIMER_REAL, patience.first())
        return is_set

    @pytest.hookimpl(tryfirst=True)
    def pytest_timeout_cancel_timer(self, item):
        self._watchdog.expect("", 0.0)

    def pytest_unconfigure(self, config):
        if hasattr(config, "workerinput"):
            return  # It waits for the others; then xdist ends it within 10 s.
        self._watchdog.expect("the end of the process", END)
        faulthandler.dump_traceback_later(END / 2, file=sys.__stderr__)  # which thread is waited for


def have_defaults() -> None:
    """Give this process, and so all that it starts, the signals of one that is started in a terminal.

    In the background of a script Ctrl-C is ignored, under nohup also the end of the terminal: what a test starts would
    inherit that. This process itself goes on under nohup, as handlers are not inherited.
    """
    signal.pthread_sigmask(signal.SIG_SETMASK, ())
    for number in sorted(signal.valid_signals() - {*IGNORED_AT_START}):
        if signal.getsignal(number) is signal.SIG_IGN:
            signal.signal(number, _handler(number))


def _handler(number: int):
    if number == signal.SIGINT:
        return signal.default_int_handler
    return (lambda *_: None) if number == signal.SIGHUP else signal.SIG_DFL


def limit(item: pytest.Item) -> None:
    """Give a test with a browser, and one of a long file, the limit of these, unless it has its own."""
    if item.get_closest_marker("timeout") is not None:
        return
    if "browser" in item.fixturenames:
        item.add_marker(pytest.mark.timeout(BROWSER))
    elif item.nodeid.partition("::")[0].removeprefix("tests/") in LONG:
        item.add_marker(pytest.mark.timeout(WHOLE))
