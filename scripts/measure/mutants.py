"""Report which random faults in mjsim and algorithms the tests detect: a table in Markdown and in JSON.

nice .venv/bin/python scripts/measure/mutants.py -o DIR [--number 200] [--seed 1] [--under mjsim/sim] [--slow]

One process collects the quick tests once. A first child runs all of them, and notes which call a function that is to
have a fault, also in programs and readers of files. Then for each fault a child gives the functions of its file their
faulty code and runs those tests, the nearest first, until one fails that passes without the fault. A fault outside of
functions, and with --slow each that survives, is tried in a process of its own, which imports the file with the fault.
The checkout stays as it is.
"""

import argparse
import ast
import functools
import gc
import importlib.util
import itertools
import json
import math
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import types
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from faults import Fault, draw

ROOT = Path(__file__).resolve().parents[2]
OWN = tuple(f"{ROOT / name}{os.sep}" for name in ("mjsim", "algorithms"))
QUICK = ["-m", "not slow", "-p", "no:cacheprovider", "-s", "--timeout", "0", "-W", "ignore::ResourceWarning"]
MOST = 60.0
"""Time that the tests of one fault may take, as measured without it [s]."""
TIMEOUT = 60.0
"""A child may take this, and five times the time of its tests, before it is killed [s]."""
CACHED = type(functools.cache(lambda: None))


@dataclass(frozen=True, slots=True)
class Outcome:
    """The outcome of a fault."""

    fault: Fault
    caught: str | None
    """The test that failed; None where it survived."""
    slow: bool = False
    tests: int = 0
    """Number of quick tests that call the function."""

    def json(self) -> dict[str, Any]:
        """Return the outcome as JSON values."""
        path = str(self.fault.path.relative_to(ROOT))
        said = {key: getattr(self.fault, key) for key in ("line", "kind", "before", "after")}
        return {"path": path, **said, "caught": self.caught, "slow": self.slow, "tests": self.tests}


class Warm:
    """Replaces pytest's loop: the tests are collected, and none has run in this process yet."""

    def __init__(self, faults: Sequence[Fault], folder: Path, site: Path, *, slow: bool) -> None:
        self._faults, self._folder, self._site, self._slow = faults, folder, site, slow
        self._said = folder / "said"
        self._sound: dict[str, bool] = {}
        """Whether a test that failed with a fault passes without it."""

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        """Try each fault."""
        for plugin in session.config.pluginmanager.get_plugins():
            if type(plugin).__name__ == "Watch":
                session.config.pluginmanager.unregister(plugin)
        gc.unfreeze()
        self._session, self._functions = session, _functions()
        self._caches = [each for each in gc.get_objects() if isinstance(each, CACHED)]
        gc.freeze()  # A pass of the collector in a child would copy all of them.
        self._items = {item.nodeid: item for item in session.items}
        self._measure()
        outcomes = []
        for number, fault in enumerate(self._faults):
            outcomes.append(self._tried(fault, self._near(number)))
            write_tables(self._folder, outcomes)
        return True

    def _measure(self) -> None:
        """Measure the time [s] of each test that passes, and which faults lie in functions that it calls."""
        probes: dict[str, dict[str, list[int]]] = defaultdict(lambda: defaultdict(list))
        for number, fault in enumerate(self._faults):
            probes[str(fault.path)][fault.function or ""].append(number)
        notes = _Notes(self._said, self._site / "reached")
        (self._site / "reached").write_bytes(bytes(len(self._faults)))
        with self._in_site("probes", json.dumps(probes)):
            self._forked(lambda: self._run(list(self._items), list(probes), notes), limit=3600.0)
        lines = [json.loads(line) for line in self._said.read_text().splitlines()]
        self._seconds = {name: seconds for name, seconds, failed, _ in lines if not failed}
        self._reached = {name: set(faults) for name, _, failed, faults in lines if not failed}
        failed = [name for name, _, failed, _ in lines if failed]
        print(f"{len(lines)} of {len(self._items)} tests ran; failed without faults: {failed}", file=sys.stderr)

    def _near(self, number: int) -> list[str]:
        """Return tests by file: those that call the function, its area first, then others of their files.

        A test may look at what another one of its file computed.
        """
        parts = self._faults[number].path.relative_to(ROOT).parts
        home = f"tests/{parts[1] if parts[0] == 'mjsim' else parts[0]}/"
        calling = [test for test in self._seconds if number in self._reached[test]]
        files = {_file(test) for test in calling}
        others = [test for test in self._seconds if _file(test) in files and number not in self._reached[test]]
        kept, total = [], 0.0
        for tests in (calling, others):
            groups = [list(group) for _, group in itertools.groupby(tests, _file)]
            groups.sort(key=lambda group: (not group[0].startswith(home), sum(map(self._seconds.__getitem__, group))))
            for test in (test for group in groups for test in group):
                total += self._seconds[test]
                if total < MOST:
                    kept.append(test)
        return kept

    def _tried(self, fault: Fault, tests: list[str]) -> Outcome:
        with self._in_site("fault", f"{fault.path}\n{fault.source}"):
            if _constants(fault) is None or (fault.function and not self._fits(fault)):
                caught = _alone([*dict.fromkeys(map(_file, tests))] or _area(fault), ["-m", "not slow"])
            else:
                caught = self._caught(fault, tests)
            if caught or not self._slow:
                return Outcome(fault, caught, tests=len(tests))
            return Outcome(fault, _alone(_area(fault), ["-m", "slow"]), slow=True, tests=len(tests))

    def _caught(self, fault: Fault, tests: list[str]) -> str | None:
        """Return the quick test that fails, and passes without the fault."""
        while tests:
            run = functools.partial(self._run, tests, [str(fault.path)], _Notes(self._said), _constants(fault) or ())
            ended = self._forked(run, limit=self._limit(tests))
            lines = [json.loads(line) for line in self._said.read_text().splitlines()]
            failed = next((name for name, _, failed, _ in lines if failed), None)
            if failed is None:
                return None if ended == 0 else f"the process ended: {ended}, after {len(lines)} tests"
            if self._passes(failed):
                return failed
            tests = tests[tests.index(failed) + 1 :]
        return None

    def _passes(self, test: str) -> bool:
        if test not in self._sound:
            fault = (self._site / "fault").rename(self._site / "aside")
            self._forked(lambda: self._run([test], [], _Notes(self._said)), limit=self._limit([test]))
            fault.rename(self._site / "fault")
            self._sound[test] = not any(json.loads(line)[2] for line in self._said.read_text().splitlines())
        return self._sound[test]

    def _limit(self, tests: Sequence[str]) -> float:
        return TIMEOUT + 5 * sum(self._seconds[test] for test in tests)

    def _fits(self, fault: Fault) -> bool:
        """Return whether functions that exist can have the faulty code; else only an import can put it in."""
        codes = _codes(compile(fault.source, str(fault.path), "exec", dont_inherit=True))
        return all(_fit(old, codes.get(key)) for key, old in self._functions[str(fault.path)])

    def _run(
        self,
        tests: Sequence[str],
        paths: Sequence[str],
        notes: "_Notes",
        constants: Sequence[tuple[str, Any, Any]] = (),
    ) -> None:
        """Run tests, in a child, with the code that the site has for some files; stop at a fault's first failure."""
        import sitecustomize

        sitecustomize.load()
        for path in paths:
            codes = _codes(sitecustomize.changed(path))
            for key, function in self._functions[path]:
                if _fit(function, code := codes.get(key)):
                    function.__code__ = code
        for module, (name, old, new) in itertools.product(_modules(), constants):
            if getattr(module, name, None) is old:
                setattr(module, name, new)
        for each in self._caches:  # What was computed before, as tests were collected, is computed anew.
            each.cache_clear()
        session, items = self._session, [self._items[test] for test in tests]
        session.config.pluginmanager.register(notes)
        for item, following in zip(items, [*items[1:], None], strict=True):
            notes.begin()
            item.config.hook.pytest_runtest_protocol(item=item, nextitem=following)
            if notes.end(item.nodeid):
                break
        session._setupstate.teardown_exact(None)

    def _forked(self, run: Callable[[], None], *, limit: float) -> int:
        """Run something in a child with a folder of its own for temporary files; return how it ended."""
        folder = Path(tempfile.mkdtemp(dir=self._site))
        self._said.write_bytes(b"")
        child = os.fork()
        if child == 0:
            code = 1
            try:
                os.setsid()
                silent = os.open(os.devnull, os.O_RDWR)
                for stream in (0, 1, 2):
                    os.dup2(silent, stream)
                self._session.config._tmp_path_factory._basetemp = folder
                tempfile.tempdir = str(folder)
                run()
                code = 0
            finally:
                os._exit(code)
        signal.signal(signal.SIGALRM, lambda *_: os.killpg(child, signal.SIGKILL))
        signal.alarm(math.ceil(limit))
        ended = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        signal.alarm(0)
        with suppress(ProcessLookupError):
            os.killpg(child, signal.SIGKILL)
        shutil.rmtree(folder, ignore_errors=True)
        return ended

    @contextmanager
    def _in_site(self, name: str, text: str) -> Iterator[None]:
        (self._site / name).write_text(text)
        yield
        (self._site / name).unlink()


class _Notes:
    """A line for each test: its name, its time [s], whether it failed, and the faults in functions that it called."""

    def __init__(self, said: Path, reached: Path | None = None) -> None:
        self._said, self._reached, self._began, self._failed = said, reached, 0.0, False

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self._failed |= report.failed

    def begin(self) -> None:
        self._began, self._failed = time.perf_counter(), False

    def end(self, test: str) -> bool:
        """Write the line; return whether no further test is needed."""
        faults = []
        if self._reached is not None:
            with self._reached.open("r+b") as file:
                faults = [number for number, called in enumerate(file.read()) if called]
                file.seek(0)
                file.write(bytes(self._reached.stat().st_size))
        with self._said.open("a") as file:
            file.write(json.dumps([test, time.perf_counter() - self._began, self._failed, faults]) + "\n")
        return self._failed and self._reached is None


def _constants(fault: Fault) -> list[tuple[str, Any, Any]] | None:
    """Return names of a module, their numbers, and the faulty ones; None where only an import can put them in."""
    if fault.function is not None:
        return []
    module = next((each for each in _modules() if each.__file__ == str(fault.path)), None)
    pairs = zip(ast.parse(fault.path.read_text()).body, ast.parse(fault.source).body, strict=True)
    new = next(new for old, new in pairs if ast.dump(old) != ast.dump(new))
    if module is None or not isinstance(new, ast.Assign):
        return None
    before = vars(module)
    exec(compile(ast.Module([new], []), str(fault.path), "exec"), after := dict(before))
    changed = [(name, before[name], after[name]) for name in before if before[name] is not after[name]]
    return changed if all(isinstance(old, float | int) for _, old, _ in changed) else None


def _modules() -> list[types.ModuleType]:
    return [each for each in list(sys.modules.values()) if (getattr(each, "__file__", None) or "").startswith(OWN)]


def write_tables(folder: Path, outcomes: Sequence[Outcome]) -> None:
    """Write both tables."""
    (folder / "mutants.json").write_text(json.dumps([each.json() for each in outcomes], indent=1))
    drawn, quick, every = (
        Counter("/".join(each.fault.path.relative_to(ROOT).parts[:-1][:2]) for each in outcomes if holds(each))
        for holds in (lambda _: True, lambda one: one.caught and not one.slow, lambda one: one.caught)
    )
    lines = ["| package | drawn | caught by quick tests | by all |", "|---|---|---|---|"]
    lines += [f"| {name} | {drawn[name]} | {quick[name]} | {every[name]} |" for name in sorted(drawn)]
    lines += [f"| all | {drawn.total()} | {quick.total()} | {every.total()} |", ""]
    for each in (each for each in outcomes if not each.caught or each.slow):
        fault = each.fault
        lines += [f"{fault.path.relative_to(ROOT)}:{fault.line}: {fault.kind}; {each.tests} tests; {each.caught}"]
        lines += ["```diff", f"- {fault.before}", f"+ {fault.after}", "```", ""]
    (folder / "mutants.md").write_text("\n".join(lines))


def _file(test: str) -> str:
    return test.partition("::")[0]


def _functions() -> dict[str, list[tuple[tuple[str, int], types.FunctionType]]]:
    """Return the functions of each file of ours, each with its qualified name and first line."""
    found: dict[str, Any] = defaultdict(list)
    for each in gc.get_objects():
        if isinstance(each, types.FunctionType) and each.__code__.co_filename.startswith(OWN):
            found[each.__code__.co_filename].append(((each.__code__.co_qualname, each.__code__.co_firstlineno), each))
    return found


def _codes(code: types.CodeType) -> dict[tuple[str, int], types.CodeType]:
    """Return a code and those within it by qualified name and first line."""
    found = {(code.co_qualname, code.co_firstlineno): code}
    for inner in code.co_consts:
        if isinstance(inner, types.CodeType):
            found |= _codes(inner)
    return found


def _fit(old: types.FunctionType, code: types.CodeType | None) -> bool:
    return code is not None and len(code.co_freevars) == len(old.__code__.co_freevars)


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
    with subprocess.Popen(command, cwd=ROOT, text=True, stdout=subprocess.PIPE, start_new_session=True) as program:
        signal.signal(signal.SIGALRM, lambda *_: os.killpg(program.pid, signal.SIGKILL))
        signal.alarm(math.ceil(5 * MOST))
        out, _ = program.communicate()
        signal.alarm(0)
    failed = [line.split()[1] for line in out.splitlines() if line.startswith(("FAILED", "ERROR"))]
    ended = program.returncode
    return failed[0] if failed else None if ended in (0, 5, -signal.SIGKILL) else f"pytest ended: {ended}"


def run(faults: Sequence[Fault], folder: Path, *, tests: Sequence[str] = ("tests",), slow: bool = False) -> None:
    """Try faults, and write the tables."""
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as place:
        shutil.copy(Path(__file__).with_name("fault_site.py"), Path(place) / "sitecustomize.py")
        os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, [place, os.environ.get("PYTHONPATH")]))
        spec = importlib.util.spec_from_file_location("sitecustomize", Path(place) / "sitecustomize.py")
        sys.modules["sitecustomize"] = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(sys.modules["sitecustomize"])
        warm = Warm(faults, folder.resolve(), Path(place), slow=slow)
        os.chdir(ROOT)
        pytest.main([*QUICK, "--confcutdir", "tests", *tests], plugins=[warm])


def main() -> None:
    """Run the program."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", dest="folder", type=Path, required=True)
    parser.add_argument("--number", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--under", nargs="*", default=["mjsim", "algorithms"])
    parser.add_argument("--tests", nargs="*", default=["tests"])
    parser.add_argument("--slow", action="store_true")
    options = parser.parse_args()
    paths = [path for name in options.under for path in sorted((ROOT / name).rglob("*.py")) or [ROOT / name]]
    faults = draw(paths, number=options.number, seed=options.seed)
    run(faults, options.folder, tests=options.tests, slow=options.slow)
    print((options.folder / "mutants.md").read_text())


if __name__ == "__main__":
    main()
