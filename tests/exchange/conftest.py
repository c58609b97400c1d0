"""All importers of a test session run in one guarded child, as in a program that reads many files."""

import pytest

from mjsim.guarded import one_reader


@pytest.fixture(scope="session", autouse=True)
def one_child(tmp_path_factory, request):
    with one_reader("mjsim.exchange.inside:world_file", folders=["/"]) as reader:
        yield reader
