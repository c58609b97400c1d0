"""What hangs where no limit within its process reaches is ended from outside, and named."""

import signal
import sys
import time
from pathlib import Path

import pytest

from tests.children import child, completed
from tests.limits import GRACE, IDLE, LOADED, WINDOW, have_defaults

ROOT = Path(__file__).parent.parent
SOONER = (("GRACE", GRACE, 0.5), ("LOADED", LOADED, 3.0), ("WINDOW", WINDOW, 0.5), ("IDLE", IDLE, 0.01))
STUCK = """
import ctypes, signal, pytest

@pytest.mark.timeout(0.5)
def test_stuck():
    signal.pthread_sigmask(signal.SIG_BLOCK, signal.valid_signals())
    ctypes.CDLL(None).sleep(1000)
"""
SIGNALS = (signal.SIGHUP, signal.SIGINT, signal.SIGQUIT, signal.SIGTERM, signal.SIGPIPE, signal.SIGCHLD)
SHOWN = f"import signal; print(*(signal.getsignal(each) is signal.SIG_IGN for each in {[*map(int, SIGNALS)]}))"

OWN_SESSION = """
import subprocess, sys
sleeper = [sys.executable, "-c", "import time; time.sleep(60)"]
with subprocess.Popen(sleeper, start_new_session=True, stdout=subprocess.DEVNULL) as process:
    print(process.pid, flush=True)
"""


@pytest.fixture
def tests(tmp_path):
    """A folder with the rules of these tests, where a limit is over sooner."""
    (tmp_path / "tests").mkdir()
    for name in ("__init__", "conftest", "limits", "shares", "watchdog", "children"):
        text = (ROOT / "tests" / f"{name}.py").read_text()
        for of, told, here in SOONER:
            text = text.replace(f"{of} = {told}", f"{of} = {here}")
        (tmp_path / "tests" / f"{name}.py").write_text(text)
    (tmp_path / "pyproject.toml").write_bytes((ROOT / "pyproject.toml").read_bytes())
    (tmp_path / "tests" / "test_stuck.py").write_text(STUCK)
    return tmp_path


def ran(folder, *words):
    # With a folder of its own: who ends in the common one removes there what whole runs left, which takes a minute.
    own = ["--basetemp", folder / "tmp"]
    return completed([sys.executable, "-m", "pytest", *own, *words], check=False, cwd=folder)


@pytest.mark.slow
def test_a_worker_that_is_stuck_in_c_with_signals_blocked_is_ended_and_the_others_go_on(tests):
    (tests / "tests" / "test_well.py").write_text("def test_well(): pass\n")
    done = ran(tests, "--numprocesses", "1", "--dist", "loadfile")
    assert "watchdog: tests/test_stuck.py::test_stuck took more than 4 s" in done.stderr
    assert "FAILED tests/test_stuck.py::test_stuck - worker 'gw0' crashed" in done.stdout
    assert "1 failed, 1 passed" in done.stdout
    assert done.returncode == 1


@pytest.mark.slow
def test_what_a_worker_had_done_before_it_was_stuck_is_not_shared_out_again(tests):
    """Files of before are the largest, and so run first; who waits for the last ones must not wait for ever."""
    for number in range(30):
        (tests / "tests" / f"test_before_{number}.py").write_text(f"def test_before(): pass\n{2000 * '#'}\n")
    for number in range(6):
        (tests / "tests" / f"test_late_{number}.py").write_text("import time\ndef test_late(): time.sleep(1.5)\n")
    done = ran(tests, "--numprocesses", "2", "--dist", "loadfile")
    assert "1 failed, 36 passed" in done.stdout
    assert done.returncode == 1


@pytest.mark.slow
def test_without_workers_it_is_ended_and_named_too(tests):
    done = ran(tests)
    assert "watchdog: tests/test_stuck.py::test_stuck took more than 4 s" in done.stderr
    assert done.returncode == -signal.SIGKILL


WAITS = """
import threading, time, pytest

@pytest.mark.timeout(1.0)
def test_waits():
    threading.Lock().acquire() and threading.Event().wait()

@pytest.mark.timeout(1.0)
def test_computes_for_less():
    ends = time.monotonic() + 2.0
    while time.monotonic() < ends:
        time.sleep(0.05)
        sum(range(1_000_000))

@pytest.mark.timeout(1.0)
def test_computes_for_ever():
    while True:
        pass
"""


@pytest.mark.slow
def test_who_waits_or_computes_for_ever_is_ended_at_its_limit_and_who_is_slowed_down_is_not(tests):
    (tests / "tests" / "test_stuck.py").write_text(WAITS)
    done = ran(tests, "-rA")
    assert "FAILED tests/test_stuck.py::test_waits - Failed: Timeout (>1.0s)" in done.stdout
    assert "FAILED tests/test_stuck.py::test_computes_for_ever - Failed: Timeout (>1.0s)" in done.stdout
    assert "PASSED tests/test_stuck.py::test_computes_for_less" in done.stdout
    assert done.stderr == ""


@pytest.mark.slow
def test_of_a_file_that_cannot_be_imported_the_error_is_shown_and_the_others_go_on(tests):
    (tests / "tests" / "test_stuck.py").write_text("import nothing_of_that_name\n")
    (tests / "tests" / "test_well.py").write_text("def test_well(): pass\n")
    done = ran(tests, "--numprocesses", "1", "--dist", "loadfile")
    assert "No module named 'nothing_of_that_name'" in done.stdout
    assert "1 passed, 1 error" in done.stdout
    assert done.returncode == 1


@pytest.mark.parametrize("number", SIGNALS)
def test_tests_begin_with_signals_at_their_defaults_whoever_started_them(number):
    before = signal.signal(number, signal.SIG_IGN)
    try:
        have_defaults()
        assert completed([sys.executable, "-c", SHOWN]).stdout.split() == [
            str(each == signal.SIGPIPE)
            for each in SIGNALS  # Python ignores it, whoever starts it
        ]
    finally:
        signal.signal(number, before)


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="this system does not tell what a process has started")
def test_what_a_program_starts_in_a_session_of_its_own_is_killed_with_it():
    with child([sys.executable, "-c", OWN_SESSION]) as program:
        started = Path("/proc", program.line().strip(), "stat")
        assert started.exists()
    end = time.monotonic() + 10.0
    while runs(started):
        assert time.monotonic() < end
        time.sleep(0.01)


def runs(stat):
    """Whether a process has not ended; what was killed may be left for its new parent to reap."""
    try:
        return stat.read_text().rpartition(")")[2].split()[0] not in "ZX"
    except (FileNotFoundError, ProcessLookupError):
        return False
