"""Waiting for what may not come ends: here and in mjsim each wait has a limit, or is named with the reason."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
WAITS = {"wait", "communicate", "join", "get", "result", "recv", "recv_bytes", "acquire", "readline"}
"""Methods that wait for ever when they are called without any argument."""
PROGRAMS = {"run", "call", "check_call", "check_output", "getoutput", "getstatusoutput"}
"""Functions of subprocess that wait for the end of a program."""
UNLIMITED = {
    "session.result()": "a run lasts as long as its user wants; Ctrl-C, or the limit of a test, ends the wait",
    "self._loaded.result()": "the thread that loads has ended",
    "subprocess.run(words, cwd=script.parent, stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, check=False)": (
        "a script of Octave lasts as long as its user wants; Ctrl-C reaches Octave too"
    ),
    "os.waitpid(copy, 0)": "the copy of the process ends at once",
    "page.wait()": "serves until Ctrl-C",
    "self._server.wait()": "serves until Ctrl-C, which it looks for each second",
    "self.changed.wait()": "a run that is paused or has ended waits for its user",
    "self.wait()": "as `session.result()`",
    "live.session.result()": "as `session.result()`",
    "future.result()": "the future is done",
    "listening.recv_bytes()": "the end of the other process ends it",
    "pipe.recv()": "a request, or the end of the other process; an answer is there",
    "self._ready.get()": "the thread ends with a picture, None, or what it raised",
    "self._free.get()": "there are as many workers as threads",
    "process.wait()": "of a process that was killed",
    "self._thread.join()": "the thread writes what is queued, or fails, however slow the disk is",
    "imu.join()": "gives a list; it does not wait",
    "self.bio.readline()": "of a file",
    "os.waitpid(self._pid, 0)": "of a process that was killed",
    "os.waitpid(pid, 0)": "of a process that was killed",
    "_SHARED.get()": "a context variable",
    "REPORT.get()": "a context variable",
    "MISSING.get()": "a context variable",
    "os.waitpid(child, 0)": "of a process that was killed",
}
"""Text of a call -> why what is awaited comes, or why nobody is kept from ending the wait."""
OWNERS = {"tests/children.py", "tests/limits.py"}
"""Who may start programs in tests: they kill them."""


_SUSPICIOUS = re.compile(
    rf"\.({'|'.join(WAITS)})\(\)|\bsubprocess\.({'|'.join(PROGRAMS)})\b|\bselect\.select\b|\bos\.wait"
)
"""What a source needs to have for a wait: parsing all takes seconds."""


def waits(source: str) -> list[str]:
    """Return the text of each wait without a limit; those of coroutines end with their connections."""
    if not _SUSPICIOUS.search(source):
        return []
    tree = ast.parse(source)
    awaited = {id(call) for node in ast.walk(tree) if isinstance(node, ast.Await) for call in ast.walk(node)}
    calls = [node for node in ast.walk(tree) if isinstance(node, ast.Call) and id(node) not in awaited]
    return [ast.unparse(call) for call in calls if _is_unlimited(call)]


def _is_unlimited(call: ast.Call) -> bool:
    named = {keyword.arg for keyword in call.keywords}
    match call.func:
        case ast.Attribute(value=ast.Name(id="subprocess"), attr=name) if name in PROGRAMS:
            return "timeout" not in named
        case ast.Attribute(value=ast.Name(id="select"), attr="select"):
            return len(call.args) < 4
        case ast.Attribute(value=ast.Name(id="os"), attr="waitpid" | "wait"):
            return True
        case ast.Attribute(attr=name) if name in WAITS:
            return not call.args and not named
    return False


@pytest.mark.parametrize("folder", ["mjsim", "algorithms", "tests"])
def test_every_wait_has_a_limit_or_a_reason(folder):
    found = {str(path.relative_to(ROOT)): waits(path.read_text()) for path in sorted((ROOT / folder).rglob("*.py"))}
    wrong = [f"{path}: {wait}" for path in sorted(found) for wait in found[path] if wait not in UNLIMITED]
    assert wrong == []


@pytest.mark.parametrize(
    ("line", "count"),
    [
        ("thread.join()", 1),
        ("thread.join(5.0)", 0),
        ("await event.wait()", 0),
        ("', '.join(words)", 0),
        ("process.wait(timeout=3)", 0),
        ("subprocess.run(['true'])", 1),
        ("subprocess.run(['true'], timeout=3)", 0),
        ("select.select([a], [], [])", 1),
        ("os.waitpid(pid, 0)", 1),
    ],
)
def test_a_wait_without_a_limit_is_found(line, count):
    assert len(waits(f"async def f():\n    {line}\n")) == count


def test_programs_of_tests_have_an_owner_that_kills_them():
    sources = {path: path.read_text() for path in (ROOT / "tests").rglob("*.py")}
    suspicious = {path: ast.walk(ast.parse(text)) for path, text in sources.items() if "subprocess.Popen(" in text}
    calls = {
        path: {ast.unparse(node.func) for node in found if isinstance(node, ast.Call)}
        for path, found in suspicious.items()
    }
    assert {str(path.relative_to(ROOT)) for path, names in calls.items() if "subprocess.Popen" in names} == OWNERS


def test_coroutines_in_tests_have_a_loop_of_their_own():
    """Playwright holds that of the thread: alone, a file that has another one passes."""
    tests = [file for file in (ROOT / "tests").rglob("*.py") if file.name not in ("loops.py", Path(__file__).name)]
    assert [file.name for file in tests if "asyncio.run(" in file.read_text()] == []
