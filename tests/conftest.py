"""What all tests have in common: their limits, one browser, and a home of their own."""

import gc
import itertools
import sys

import pytest

from mjsim.guarded import one_reader
from tests import shares
from tests.limits import Watch, have_defaults, limit

FEWER_PASSES = 10_000
"""New objects until the garbage collector looks for cycles: at Python's 700 it took a twentieth of the tests' time."""
FOLDERS = itertools.count()

have_defaults()


def pytest_configure(config):
    config.pluginmanager.register(shares)
    if hasattr(config, "workerinput") or not config.option.numprocesses:
        config.pluginmanager.register(Watch())


def pytest_sessionfinish(session):
    """Keep the plugin of hypothesis from loading all of it, half a second, where no test has used it."""
    plugins = session.config.pluginmanager
    if "hypothesis" not in sys.modules and plugins.has_plugin("hypothesispytest"):
        plugins.unregister(name="hypothesispytest")


def pytest_ignore_collect(collection_path, config):
    """Leave files of slow tests alone where none is asked for: what they import takes a tenth of the collection."""
    quick = config.option.markexpr == "not slow" and collection_path.suffix == ".py"
    return True if quick and "\npytestmark = pytest.mark.slow" in collection_path.read_text(encoding="utf-8") else None


def pytest_itemcollected(item):
    if isinstance(item, pytest.Function):
        limit(item)


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """Leave all that is imported and collected to the end of the run: the garbage collector need not look through it.

    Its passes took a fifth of the collection and a twentieth of the tests.
    """
    with shares.without_collector():
        found = yield
        gc.freeze()
        gc.set_threshold(FEWER_PASSES)
        return found


@pytest.fixture(autouse=True, scope="session")
def own_state(tmp_path_factory):
    """Keep what programs remember of a user in a folder of the tests."""
    with pytest.MonkeyPatch.context() as patch:
        for kind in ("STATE", "CACHE"):
            patch.setenv(f"XDG_{kind}_HOME", str(tmp_path_factory.mktemp(kind)))
        yield


@pytest.fixture
def tmp_path(tmp_path_factory):
    """A folder of the test's own; for each, pytest's looks through those of all tests before and makes a link."""
    place = tmp_path_factory.getbasetemp() / f"test-{next(FOLDERS)}"
    place.mkdir()
    return place


@pytest.fixture(scope="session")
def browser():
    """One browser for all tests of a process; each page has a window that remembers nothing."""
    from tests.windows import chromium

    with chromium() as browser:
        yield browser


@pytest.fixture(scope="session", autouse=True)
def one_child():
    """Files of strangers are read in one guarded child for all tests of a process; the first of them starts it."""
    with one_reader("mjsim.models.trials:picture", folders=["/"]):
        yield
