"""What all tests have in common: nothing is written into the home of who runs them."""

import pytest


@pytest.fixture(autouse=True, scope="session")
def own_state(tmp_path_factory):
    """Keep what programs remember of a user in a folder of the tests."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_STATE_HOME", str(tmp_path_factory.mktemp("state")))
        yield
