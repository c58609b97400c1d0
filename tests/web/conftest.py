"""A studio of a folder with one world, and a client that it has let in; most files have their own."""

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
