"""Report which random faults in mjsim and algorithms the tests detect: a table in Markdown and in JSON.

nice .venv/bin/python scripts/measure/mutants.py -o DIR [--number 200] [--seed 1] [--under mjsim/sim] [--kinds sign]

One process collects the quick tests once. For each fault it forks: the child gives the functions of that file their
faulty code and runs the tests that call the faulty function, the nearest first, until one fails. Which test calls which
function is measured before, once; DIR keeps it. A fault outside of functions, and with --slow each that survives, is
tried in a process of its own, in which the file is imported with the fault. The checkout stays as it is.
"""

import argparse
import functools
import gc
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import types
from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from hashlib import sha256
from pathlib import Path
from typing import Any

import pytest
from faults import Fault, draw
from outcomes import Outcome, write_table

ROOT = Path(__file__).resolve().parents[2]
OWN = tuple(f"{ROOT / name}{os.sep}" for name in ("mjsim", "algorithms"))
QUICK = ["-m", "not slow", "-p", "no:cacheprovider", "-s"]
MOST = 60.0
"""Time that the tests of one fault may take, as measured without it [s]."""
PATIENCE = 40.0
"""A child may take this, and five times the time of its tests, before it is killed [s]."""
CACHED = type(functools.cache(lambda: None))
SITE = """
import os, sys
from importlib.machinery import SourceFileLoader
FOLDER, OWN = {folder!r}, {own!r}
get_code = SourceFileLoader.get_code
def faulty(self, name):
    try:
        with open(FOLDER + "/fault") as file:
            path, _, source = file.read().partition("\\n")
    except OSError:
        return get_code(self, name)
    return compile(source, path, "exec", dont_inherit=True) if self.path == path else get_code(self, name)
SourceFileLoader.get_code = faulty
if os.path.exists(FOLDER + "/calls"):
    calls, seen = os.open(FOLDER + "/calls", os.O_WRONLY | os.O_APPEND), set()
    def call(frame, event, argument):
        code = frame.f_code
        if code not in seen:
            seen.add(code)
            if code.co_filename.startswith(OWN):
                try:
                    os.write(calls, f"{{code.co_filename}}:{{code.co_qualname}}\\n".encode())
                except OSError:
                    sys.settrace(None)  # a guarded reader may not write
    sys.settrace(call)
"""
"""Code that each Python of this run starts with: it loads faults, and notes which functions programs of tests call."""


class Warm:
    """Replaces pytest's loop: the tests are collected, and none has run in this process yet."""

    def __init__(self, faults: Sequence[Fault], folder: Path, site: Path, *, slow: bool) -> None:
        self._faults, self._folder, self._site, self._slow = faults, folder, site, slow

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        """Try each fault."""
        for plugin in session.config.pluginmanager.get_plugins():
            if type(plugin).__name__ == "Watch":
                session.config.pluginmanager.unregister(plugin)
        gc.unfreeze()
        self._session, self._codes = session, _functions()
        self._items = {item.nodeid: item for item in session.items}
        self._measured()
        outcomes = []
        for fault in self._faults:
            outcomes.append(self._tried(fault))
            write_table(self._folder, outcomes)
        return True

    def _measured(self) -> None:
        """Measure time [s] and called functions of each test that passes; unchanged files are left out."""
        kept = self._folder / "map.json"
        before = json.loads(kept.read_text()) if kept.exists() else {}
        notes = {}
        for file, items in _by_file(self._session.items).items():
            digest = sha256((ROOT / file).read_bytes()).hexdigest()
            notes[file] = before.get(file)
            if notes[file] is None or notes[file]["digest"] != digest or not notes[file]["seconds"]:
                notes[file] = {"digest": digest, **self._measured_file(items)}
                print(f"{file}: {len(items)}", file=sys.stderr, flush=True)
                kept.write_text(json.dumps({**before, **notes}))
        self._seconds: dict[str, float] = {}
        self._calls: dict[str, list[str]] = defaultdict(list)
        for each in notes.values():
            self._seconds |= each["seconds"]
            for function, tests in each["calls"].items():
                self._calls[function] += tests

    def _measured_file(self, items: list[pytest.Item]) -> dict[str, Any]:
        said, noted = self._folder / "said", self._site / "calls"
        said.unlink(missing_ok=True)
        noted.write_bytes(b"")
        self._forked(lambda: _measure(self._session, items, said), limit=600.0)
        seconds: dict[str, float] = {}
        calls: dict[str, list[str]] = defaultdict(list)
        for line in said.read_text().splitlines() if said.exists() else ():
            nodeid, seconds[nodeid], *called = json.loads(line)
            for function in called:
                calls[function].append(nodeid)
        # Which test a program was started for is not known: it may serve several of a file.
        for function in set(noted.read_text().split("\n")) - {""}:
            calls[function] = list(seconds)
        noted.unlink()
        return {"seconds": seconds, "calls": calls}

    def _tried(self, fault: Fault) -> Outcome:
        tests = self._near(fault)
        (self._site / "fault").write_text(f"{fault.path}\n{fault.source}")
        try:
            caught = self._caught(fault, tests)
            if caught or not self._slow:
                return Outcome(fault, caught, tests=len(tests))
            return Outcome(fault, _alone(_area(fault), ["-m", "slow"]), slow=True, tests=len(tests))
        finally:
            (self._site / "fault").unlink()

    def _caught(self, fault: Fault, tests: Sequence[str]) -> str | None:
        """Return the quick test that fails."""
        if not tests:
            return None
        patch = self._patch(fault)
        if patch is None:
            return _alone(list(dict.fromkeys(test.partition("::")[0] for test in tests)), ["-m", "not slow"])
        said = self._folder / "said"
        said.unlink(missing_ok=True)
        items = [self._items[test] for test in tests]

        def run() -> None:
            patch()
            _run(self._session, items, said)

        limit = PATIENCE + 5 * sum(self._seconds[test] for test in tests)
        ended = self._forked(run, limit=limit)
        if said.exists():
            return said.read_text()
        return None if ended == 0 else f"the process ended: {ended}"

    def _near(self, fault: Fault) -> list[str]:
        """Return the tests that call the function, or one in its file; those of its area, of few calls, come first."""
        calls, seconds, path = self._calls, self._seconds, str(fault.path)
        if fault.function is None:
            tests = {test for name, found in calls.items() if name.rpartition(":")[0] == path for test in found}
        else:
            tests = set(calls.get(f"{path}:{fault.function}", ()))
        area = fault.path.relative_to(ROOT).parts
        home = f"tests/{area[1] if area[0] == 'mjsim' else area[0]}/"
        # What only guarded readers call is not noted: the tests of its area are all there is to go by.
        tests = tests or {test for test in seconds if test.startswith(home)}
        order = sorted(tests & self._items.keys(), key=lambda test: (not test.startswith(home), seconds[test], test))
        kept, total = [], 0.0
        for test in order:
            total += seconds[test]
            if total > MOST:
                break
            kept.append(test)
        return kept

    def _patch(self, fault: Fault) -> Callable[[], None] | None:
        """Return a function that puts the faulty code into the functions of a file; None where only an import can."""
        if fault.function is None:
            return None
        codes = _codes(compile(fault.source, str(fault.path), "exec", dont_inherit=True))
        there = self._codes[str(fault.path)]
        pairs = [(function, codes.get(key)) for key, found in there.items() for function in found]
        if any(code is None or len(code.co_freevars) != len(old.__code__.co_freevars) for old, code in pairs):
            return None

        def patch() -> None:
            for function, code in pairs:
                function.__code__ = code
            for each in gc.get_objects():  # What was computed before, as tests were collected, is computed anew.
                if isinstance(each, CACHED):
                    each.cache_clear()

        return patch

    def _forked(self, run: Callable[[], None], *, limit: float) -> int:
        """Run something in a child with a folder of its own for temporary files; return how it ended."""
        folder = Path(tempfile.mkdtemp(dir=self._site))
        child = os.fork()
        if child == 0:
            code = 1
            try:
                os.setsid()
                silent = os.open(os.devnull, os.O_RDWR)
                for stream in (0, 1, 2):
                    os.dup2(silent, stream)
                self._session.config._tmp_path_factory._basetemp = folder  # type: ignore[attr-defined]
                tempfile.tempdir = str(folder)
                run()
                code = 0
            finally:
                os._exit(code)
        ended = _waited(child, limit)
        with suppress(ProcessLookupError):
            os.killpg(child, signal.SIGKILL)
        shutil.rmtree(folder, ignore_errors=True)
        return ended


def _waited(child: int, limit: float) -> int:
    end = time.monotonic() + limit
    while time.monotonic() < end:
        found, status = os.waitpid(child, os.WNOHANG)
        if found:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.02)
    with suppress(ProcessLookupError):
        os.killpg(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return -signal.SIGKILL


class _Notes:
    """The first failure, in a file."""

    def __init__(self, said: Path) -> None:
        self._said = said

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed and not self._said.exists():
            self._said.write_text(report.nodeid)


class _Amiss:
    """The tests that do not pass."""

    def __init__(self) -> None:
        self.tests = set[str]()

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.outcome != "passed":
            self.tests.add(report.nodeid)


def _run(session: pytest.Session, items: list[pytest.Item], said: Path) -> None:
    """Run tests until one fails."""
    session.config.pluginmanager.register(_Notes(said))
    for item, following in zip(items, [*items[1:], None], strict=True):
        item.config.hook.pytest_runtest_protocol(item=item, nextitem=following)
        if said.exists():
            break
    session._setupstate.teardown_exact(None)


def _measure(session: pytest.Session, items: list[pytest.Item], said: Path) -> None:
    """Write a line for each test that passes: its name, its time [s], and the functions that it calls."""
    amiss = _Amiss()
    session.config.pluginmanager.register(amiss)
    seen: set[types.CodeType] = set()

    def call(frame: types.FrameType, _: str, __: object) -> None:
        seen.add(frame.f_code)

    threading.settrace(call)
    with said.open("w") as file:
        for item, following in zip(items, [*items[1:], None], strict=True):
            began = time.perf_counter()
            sys.settrace(call)
            item.config.hook.pytest_runtest_protocol(item=item, nextitem=following)
            sys.settrace(None)
            if item.nodeid not in amiss.tests:
                called = sorted({f"{code.co_filename}:{code.co_qualname}" for code in seen if _ours(code)})
                file.write(json.dumps([item.nodeid, time.perf_counter() - began, *called]) + "\n")
                file.flush()
            seen.clear()


def _ours(code: types.CodeType) -> bool:
    return code.co_filename.startswith(OWN)


def _functions() -> dict[str, dict[tuple[str, int], list[types.FunctionType]]]:
    """Return the functions of each file of ours by qualified name and first line."""
    found: dict[str, Any] = defaultdict(lambda: defaultdict(list))
    for each in gc.get_objects():
        if isinstance(each, types.FunctionType) and _ours(each.__code__):
            found[each.__code__.co_filename][each.__code__.co_qualname, each.__code__.co_firstlineno].append(each)
    return found


def _codes(code: types.CodeType) -> dict[tuple[str, int], types.CodeType]:
    """Return a code and those within it by qualified name and first line."""
    found = {(code.co_qualname, code.co_firstlineno): code}
    for inner in code.co_consts:
        if isinstance(inner, types.CodeType):
            found |= _codes(inner)
    return found


def _by_file(items: Iterable[pytest.Item]) -> dict[str, list[pytest.Item]]:
    found: dict[str, list[pytest.Item]] = defaultdict(list)
    for item in items:
        found[item.nodeid.partition("::")[0]].append(item)
    return found


def _area(fault: Fault) -> list[str]:
    """Return the files of tests of the area that name the module, or its package."""
    parts = fault.path.relative_to(ROOT).with_suffix("").parts
    folder = ROOT / "tests" / (parts[1] if parts[0] == "mjsim" else parts[0])
    files = [path for path in sorted(folder.glob("test_*.py")) if "browser" not in path.read_text()]
    near = [path for path in files if parts[-1] in path.read_text() or parts[-2] in path.read_text()]
    return [str(path.relative_to(ROOT)) for path in (near or files)]


def _alone(files: Sequence[str], words: Sequence[str]) -> str | None:
    """Return the test of these files that fails, run in a process of its own that imports the fault."""
    if not files:
        return None
    command = [sys.executable, "-m", "pytest", "-x", "-rfE", "--tb=no", "-p", "no:cacheprovider", *words, *files]
    program = subprocess.Popen(command, cwd=ROOT, text=True, stdout=subprocess.PIPE, start_new_session=True)
    try:
        out, _ = program.communicate(timeout=5 * MOST)
    except subprocess.TimeoutExpired:
        return None
    finally:
        with suppress(ProcessLookupError):
            os.killpg(program.pid, signal.SIGKILL)
    failed = [line.split()[1] for line in out.splitlines() if line.startswith(("FAILED", "ERROR"))]
    return failed[0] if failed else None if program.returncode in (0, 5) else f"pytest ended: {program.returncode}"


def main() -> None:
    """Run the program."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", dest="folder", type=Path, required=True)
    parser.add_argument("--number", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--under", nargs="*", default=["mjsim", "algorithms"])
    parser.add_argument("--kinds", nargs="*", help="only faults of these kinds, such as 'guard removed'")
    parser.add_argument("--tests", nargs="*", default=[str(ROOT / "tests")])
    parser.add_argument("--slow", action="store_true")
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    paths = [path for name in options.under for path in sorted((ROOT / name).rglob("*.py")) or [ROOT / name]]
    faults = draw(paths, number=options.number, seed=options.seed, kinds=options.kinds)
    with tempfile.TemporaryDirectory() as place:
        site = Path(place)
        (site / "sitecustomize.py").write_text(SITE.format(folder=place, own=OWN))
        os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, [place, os.environ.get("PYTHONPATH")]))
        exec(compile((site / "sitecustomize.py").read_text(), "sitecustomize", "exec"), {})
        warm = Warm(faults, options.folder.resolve(), site, slow=options.slow)
        os.chdir(ROOT)
        pytest.main([*QUICK, "--confcutdir", "tests", *options.tests], plugins=[warm])
    print((options.folder / "mutants.md").read_text())


if __name__ == "__main__":
    main()
