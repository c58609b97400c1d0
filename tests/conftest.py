"""What all tests have in common: nothing is written into the home of who runs them."""

import gc
from collections import Counter
from pathlib import Path

import pytest

TESTS = Path(__file__).parent
LONGEST = (
    "worlds/test_shipped_worlds.py",
    "sweep/test_sweep.py",
    "algorithms/test_slam_rooms.py",
    "algorithms/test_invariant_ekf.py",
    "web/test_studio_unsaved_page.py",
    "web/test_axe_page.py",
    "web/test_studio_newcomer.py",
    "exchange/test_odometry_of_robots.py",
    "sim/test_balancing_modules.py",
    "exchange/test_map_figures.py",
    "algorithms/test_cooperative_slam.py",
    "exchange/test_robot_drives.py",
    "record/test_record_bounds.py",
    "worlds/test_matlab_world.py",
    "web/test_studio_screen_page.py",
    "world/test_large_world.py",
    "worlds/test_balancing_run.py",
    "worlds/test_gallery_run.py",
)
"""Files of 12 s of processor time and more, most of them with few tests; `--durations` tells which."""


def pytest_ignore_collect(collection_path, config):
    """Leave files of slow tests alone where none is asked for: what they import takes a tenth of the collection."""
    quick = config.option.markexpr == "not slow" and collection_path.suffix == ".py"
    return True if quick and "\npytestmark = pytest.mark.slow" in collection_path.read_text(encoding="utf-8") else None


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config, items):
    """Where processes share the tests, start the longest files first: else all wait for the last of them.

    After those that are named come the others, the more slow tests they hold the sooner.
    """
    if hasattr(config, "workerinput"):
        ranks = {TESTS / name: rank for rank, name in enumerate(LONGEST)}
        slow = Counter(item.path for item in items if item.get_closest_marker("slow"))
        places = {path: place for place, path in enumerate(dict.fromkeys(item.path for item in items))}
        items.sort(key=lambda item: (ranks.get(item.path, len(ranks)), -slow[item.path], places[item.path]))


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """Leave all that is imported and collected to the end of the run: the garbage collector need not look through it.

    Its passes took a fifth of the collection and a twentieth of the tests.
    """
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


@pytest.fixture(autouse=True, scope="session")
def own_state(tmp_path_factory):
    """Keep what programs remember of a user in a folder of the tests."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_STATE_HOME", str(tmp_path_factory.mktemp("state")))
        yield
