"""A good recording, and its parts, to be made hostile."""

import pytest

from tests.hostile_recordings import Parts, taken_apart
from tests.record_ticks import hand_made_ticks, record


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    return record(tmp_path_factory.mktemp("good") / "run.mcap", hand_made_ticks(20)).read_bytes()


@pytest.fixture
def parts(good: bytes) -> Parts:
    return taken_apart(good)
