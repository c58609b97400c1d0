"""Copies of the process of a run that a module makes end, and nothing but they."""

import os

import pytest

from mjsim.modules.boundary import end_copy


def ended(error) -> int:
    """Return how a copy of this process ends."""
    run = os.getpid()
    child = os.fork()
    if child == 0:
        try:
            end_copy(run, error)
        finally:
            os._exit(99)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


@pytest.mark.filterwarnings("ignore:This process")  # Of threads that other tests left.
@pytest.mark.parametrize(
    ("error", "code"), [(None, 0), (ValueError(), 1), (SystemExit(3), 3), (SystemExit("gone"), 1), (SystemExit(0), 0)]
)
def test_a_copy_ends_with_the_code_of_what_ended_it(error, code):
    assert ended(error) == code


def test_the_process_of_the_run_goes_on():
    end_copy(os.getpid(), ValueError())
