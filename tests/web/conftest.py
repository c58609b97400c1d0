"""A studio of a folder with one world, a client that it has let in, and its page in a browser."""

import pytest

from mjsim.bench.entering import client_of
from mjsim.web.studio import Studio
from tests.asking import ROOM


@pytest.fixture
def folder(tmp_path):
    place = tmp_path / "worlds"
    place.mkdir()
    (place / "room.yaml").write_text(ROOM)
    return place


@pytest.fixture
def studio(folder):
    with Studio(folder) as page:
        yield page


@pytest.fixture
def client(studio):
    with client_of(studio.url) as browser:
        yield browser


@pytest.fixture
def sheet(browser, tmp_path, request):
    """The Edit view of the room of a module of tests, in a window of its own where the module has OWN_WINDOW."""
    from tests.sheet import sheet_of

    module = request.module
    with sheet_of(browser, tmp_path, module.ROOM, own=hasattr(module, "OWN_WINDOW")) as sheet:
        yield sheet


@pytest.fixture
def state(tmp_path_factory, monkeypatch):
    """A folder of the test's own for what a studio remembers of a user."""
    place = tmp_path_factory.mktemp("state")
    monkeypatch.setenv("XDG_STATE_HOME", str(place))
    return place
