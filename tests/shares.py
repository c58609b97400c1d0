"""Each process of tests collects a file when its turn comes: else every process would import all of them.

For processes of xdist that share whole files, where no single tests are asked for.
"""

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from _pytest.runner import runtestprotocol
from xdist.scheduler import LoadFileScheduling

from tests.limits import LONGEST

if TYPE_CHECKING:
    from xdist.workermanage import WorkerController

TESTS = Path(__file__).parent
WORTH_TELLING = 0.1
"""Of a test that passed, a set-up or an end of this time is told for the list of the slowest [s]."""
running: dict[str, str] = {}
"""File -> its test that was begun last, for the process that shares them out."""


class AllTests(pytest.Item):
    """All tests of a file, until their process collects them; the only item of a file that xdist shares out."""

    def runtest(self) -> None:
        raise NotImplementedError("its tests run in its place")


class UnreadFile(pytest.File):
    """A file of tests that is not imported yet."""

    def collect(self) -> Iterator[AllTests]:
        yield AllTests.from_parent(self, name="all")


def shares(config: pytest.Config) -> bool:
    """Return whether this process shares whole files with others."""
    return hasattr(config, "workerinput") and not any("::" in word for word in config.args)


@pytest.hookimpl(tryfirst=True)
def pytest_pycollect_makemodule(module_path, parent):
    return UnreadFile.from_parent(parent, path=module_path) if shares(parent.config) else None


@pytest.hookimpl(wrapper=True)
def pytest_collection_modifyitems(config, items):
    """Keep files from what leaves out tests by their names and marks, and order them: the longest first."""
    files = [item for item in items if isinstance(item, AllTests)]
    items[:] = [item for item in items if not isinstance(item, AllTests)]
    yield
    ranks = {TESTS / name: rank for rank, name in enumerate(LONGEST)}
    files.sort(key=lambda item: (ranks.get(item.path, len(ranks)), -item.path.stat().st_size))
    items[:] = [*files, *items]


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_protocol(item, nextitem):
    """Collect and run the tests of a file in the place of its only item: xdist expects each report there."""
    if not isinstance(item, AllTests):
        return _run(item, nextitem) if shares(item.config) else None
    session = item.session
    place, tests = session.items.index(item), _tests_of(item)
    for test, following in zip(tests, [*tests[1:], nextitem], strict=False):  # of none there is no next one
        session.items[place] = test
        item.config.hook.pytest_runtest_protocol(item=test, nextitem=following)
        if session.shouldfail or session.shouldstop:
            break
    session.items[place] = item
    if not tests:  # else the end of its last test does this, for which pytest has nothing public
        session._setupstate.teardown_exact(nextitem)
    return True


def _run(item: pytest.Item, nextitem: pytest.Item | None) -> bool:
    """Run a test, and tell little: of five messages each costs both processes as much as the shortest tests take."""
    item.ihook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
    for report in runtestprotocol(item, log=False, nextitem=nextitem):
        if report.when == "call" or not report.passed or report.duration >= WORTH_TELLING:
            item.ihook.pytest_runtest_logreport(report=report)
    return True


def _tests_of(item: AllTests) -> list[pytest.Item]:
    file, session = item.parent, item.session
    with without_collector():
        tests = list(session.genitems(pytest.Module.from_parent(file.parent, path=item.path)))
    item.config.hook.pytest_collection_modifyitems(session=session, config=item.config, items=tests)
    return tests


@contextmanager
def without_collector() -> Iterator[None]:
    """Leave the garbage collector out of imports: its passes took a fifth of their time."""
    gc.disable()
    try:
        yield
    finally:
        gc.enable()


def pytest_runtest_logstart(nodeid):
    running[nodeid.partition("::")[0]] = nodeid


def pytest_handlecrashitem(crashitem, report):
    """Name the test in which a process ended."""
    file = crashitem.partition("::")[0]
    report.nodeid = running.get(file, crashitem)
    report.longrepr = f"{report.longrepr}: {report.nodeid}; what follows in this file was left out"


class Files(LoadFileScheduling):
    """Files shared out to processes, of which some end too early."""

    def remove_node(self, node: "WorkerController") -> str | None:
        """Share out again what a process had not begun, and return the item in which it ended, if any.

        xdist also shares out what was done: who gets that has nothing to do, tells nothing, and so gets nothing more.
        """
        load = self.assigned_work.pop(node)
        left = {scope: [name for name, done in unit.items() if not done] for scope, unit in load.items()}
        names = [name for unit in left.values() for name in unit]
        if not names:
            return None
        for scope, unit in left.items():
            if unbegun := dict.fromkeys([name for name in unit if name != names[0]], False):
                self.workqueue[scope] = unbegun
        for other in self.assigned_work:
            self._reschedule(other)
        return names[0]


def pytest_xdist_make_scheduler(config, log):
    return Files(config, log) if config.getvalue("dist") == "loadfile" else None
