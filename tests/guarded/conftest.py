"""Each call has a child of its own here."""

import pytest

from mjsim.guarded import reader


@pytest.fixture(autouse=True)
def own_children():
    token = reader._SHARED.set(None)
    yield
    reader._SHARED.reset(token)
