"""Each call has a child of its own here."""

import pytest

from mjsim.guarded import guarded_reader


@pytest.fixture(autouse=True)
def own_children():
    token = guarded_reader._SHARED.set(None)
    yield
    guarded_reader._SHARED.reset(token)
