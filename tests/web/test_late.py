"""Routes that are loaded while the server already serves."""

import threading

import pytest
from starlette.responses import PlainTextResponse
from starlette.routing import Route

from mjsim.web.server.late import LateRoutes, Loaded
from tests.loops import in_a_loop
from tests.web.in_process import asked

EARLY = Route("/early", lambda _: PlainTextResponse("early"))


def answer_of(late, address):
    return in_a_loop(lambda: asked([EARLY, late.mount], "GET", address))


def test_a_request_waits_until_its_route_is_loaded_and_what_was_loaded_is_closed():
    may_load, closed = threading.Event(), []

    def load():
        assert may_load.wait(5.0)
        return Loaded([Route("/late", lambda _: PlainTextResponse("late"))], [lambda: closed.append(True)])

    late = LateRoutes(load)
    late.start()
    assert answer_of(late, "/early").text == "early"
    threading.Timer(0.02, may_load.set).start()
    assert answer_of(late, "/late").text == "late"
    assert answer_of(late, "/other").status_code == 404
    late.close()
    assert closed == [True]


def test_what_could_not_be_loaded_for_lack_of_files_is_loaded_again():
    errors = [OSError(24, "Too many open files"), ImportError("cannot open a.so: Too many open files")]

    def load():
        if errors:
            raise errors.pop()
        return Loaded([Route("/late", lambda _: PlainTextResponse("late"))], [])

    late = LateRoutes(load)
    late.start()
    assert answer_of(late, "/late").text == "late"
    late.close()


def test_an_error_while_loading_is_the_answer_to_each_request_and_closing_is_quiet():
    def load():
        raise ImportError("no MuJoCo")

    late = LateRoutes(load)
    late.start()
    for _ in range(2):
        with pytest.raises(ImportError, match="no MuJoCo"):
            answer_of(late, "/late")
    late.close()


def test_what_was_never_started_is_closed_without_loading():
    LateRoutes(pytest.fail).close()
