"""Syntax trees are made in many threads at once, which CPython 3.11 alone cannot do."""

import ast
import gc
import inspect
import sys
import threading
from pathlib import Path

import pytest

import mjsim
from mjsim.closing import join
from mjsim.syntax import parse_python

ROOT = Path(mjsim.__file__).parent
THREADS, ROUNDS = 3, 5


def deeper(calls, work):
    """Work so many calls further down: threads differ in depth, which is what collides."""
    return work() if calls == 0 else deeper(calls - 1, work)


@pytest.fixture
def eager_switches():
    """Let threads take turns as often as they can, also within a conversion, where the collector calls Python."""

    def turn(phase, info):
        sum(range(20))

    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    gc.callbacks.append(turn)
    yield
    gc.callbacks.remove(turn)
    sys.setswitchinterval(interval)


def faults_of(parse):
    """Parse large sources in several threads, each at another depth of the stack; return what was raised."""
    sources = [Path(inspect.getfile(module)).read_bytes() for module in (ast, threading)]
    faults = []

    def work():
        for _ in range(ROUNDS):
            for source in sources:
                try:
                    parse(source)
                except SystemError as error:
                    faults.append(str(error))

    threads = [threading.Thread(target=deeper, args=(40 * k, work)) for k in range(THREADS)]
    for thread in threads:
        thread.start()
    for thread in threads:
        join(thread, within=60.0)
    return faults


@pytest.mark.slow
def test_sources_are_parsed_in_threads_at_once_and_again_where_they_collide_with_one_elsewhere(eager_switches):
    strangers = threading.Thread(target=faults_of, args=(ast.parse,))
    strangers.start()
    assert faults_of(parse_python) == []
    join(strangers, within=60.0)


def test_all_of_mjsim_parses_there():
    others = [file for file in ROOT.rglob("*.py") if "ast.parse(" in file.read_text()]
    assert others == [ROOT / "syntax.py"]


def test_what_is_not_python_is_said_with_its_file_and_line():
    with pytest.raises(SyntaxError) as caught:
        parse_python("x = 1\ny = (\n", file="odd.py")
    assert (caught.value.filename, caught.value.lineno) == ("odd.py", 2)
