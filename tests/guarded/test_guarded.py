"""The guarded reader: whatever a decoder does, its caller gets a value or one line, and nothing else happens."""

import io
import os
import signal
import sys
import time
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from mjsim.errors import RecordingError, UsageError, WorldError
from mjsim.guarded import Reader, guarded, guarded_parts
from mjsim.guarded.limits import Allowance, limits_for
from mjsim.guarded.plain_values import HEAD_DIVISOR, WireError, receive
from mjsim.light.crew import _worker
from tests.children import child
from tests.guarded import decoders
from tests.watchdog import offspring

HERE = "tests.guarded.decoders"
linux = pytest.mark.skipif(sys.platform != "linux", reason="other systems have no such limits")


@pytest.fixture(scope="module")
def reader():
    with Reader(f"{HERE}:same") as reader:
        yield reader


def said(call, *arguments, **keywords):
    """Return the line that a call of the reader ends with."""
    with pytest.raises(UsageError) as caught:
        call(*arguments, about="x.mat", **keywords)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_a_file_is_read_in_a_process_of_its_own(tmp_path):
    file = tmp_path / "a.txt"
    file.write_text("seen")
    assert guarded(f"{HERE}:text_of", file, about=file) == "seen"


def test_plain_values_come_back_as_they_are(reader):
    value = {"a": [1, 2.5, None, True], "b": (float("inf"), "\udc80 ä"), "c": b"\0\xff", "d": {"e": 2**200}}
    assert reader.call(f"{HERE}:same", value, about="x") == value


@pytest.mark.parametrize("kind", ["bool", "uint8", "int64", "float32", ">f8"])
def test_arrays_come_back_with_type_shape_and_values(reader, kind):
    for array in (np.arange(12).reshape(3, 4).astype(kind), np.zeros((0, 2), kind), np.arange(9).astype(kind)[::2]):
        found = reader.call(f"{HERE}:same", array, about="x")
        np.testing.assert_array_equal(found, array)
        assert (found.dtype, found.shape) == (array.dtype.newbyteorder("="), array.shape)
        assert found.flags.writeable


def test_one_child_serves_many_calls(reader):
    assert reader.call(f"{HERE}:process", about="x") == reader.call(f"{HERE}:process", about="y") != os.getpid()


@linux
def test_the_ctrl_c_of_a_terminal_reaches_no_child(reader):
    assert os.getsid(reader.call(f"{HERE}:process", about="x")) != os.getsid(0)
    before = {*offspring(os.getpid())}
    with _worker():  # of those that bake light
        (worker,) = {*offspring(os.getpid())} - before
        assert os.getsid(worker) != os.getsid(0)


def test_parts_come_as_they_are_made_and_an_error_where_it_is():
    parts = guarded_parts(f"{HERE}:count", 3, then="the rest is cut", about="x.log")
    assert [next(parts) for _ in range(3)] == [0, 1, 2]
    with pytest.raises(UsageError, match="the rest is cut"):
        next(parts)


def test_who_stops_early_ends_the_child(reader):
    before = reader.call(f"{HERE}:process", about="x")
    with closing(reader.parts(f"{HERE}:slow_parts", 0.0, about="x")) as parts:
        assert next(parts) == 1
    assert reader.call(f"{HERE}:process", about="x") != before


def test_a_crash_is_one_line_and_the_next_file_is_read(reader):
    assert said(reader.call, f"{HERE}:crash") == (
        "'x.mat' cannot be read: its reader crashed (SIGSEGV); the file may be damaged"
    )
    assert reader.call(f"{HERE}:same", 1, about="y") == 1


@pytest.mark.parametrize("function", ["hang", pytest.param("turn", marks=pytest.mark.slow)])
def test_what_never_ends_is_ended(function, monkeypatch):
    monkeypatch.setattr("mjsim.guarded.guarded_reader.limits_for", lambda size: Allowance(seconds=0.51))
    with Reader(f"{HERE}:same") as reader:
        reader.call(f"{HERE}:same", 1, about="x")
        before = time.monotonic()
        assert said(reader.call, f"{HERE}:{function}").startswith("'x.mat' cannot be read: it took longer than 1 s")
        assert time.monotonic() - before < 30.0  # a busy machine gives it little of its time


def test_parts_that_stop_coming_are_ended(monkeypatch):
    monkeypatch.setattr("mjsim.guarded.guarded_reader.limits_for", lambda size: Allowance(seconds=0.5))
    with pytest.raises(UsageError, match="longer than"):
        list(guarded_parts(f"{HERE}:slow_parts", 0.2, about="x"))


@linux
def test_memory_is_bounded(reader):
    assert said(reader.call, f"{HERE}:swell", 900).startswith("'x.mat' cannot be read: it needs more than 805 MB")


@pytest.mark.slow
@linux
def test_what_lacks_memory_in_a_used_child_is_read_by_a_new_one():
    with Reader(f"{HERE}:same") as reader:
        reader.call(f"{HERE}:hoard", 400, about="x")
        assert reader.call(f"{HERE}:swell", 400, about="y") == 400 << 20


def test_a_head_that_would_take_the_memory_of_the_caller_is_not_read():
    head = io.BytesIO((Allowance().answer // HEAD_DIVISOR + 1).to_bytes(8, "little"))
    with pytest.raises(WireError, match="a head of"):
        receive(head, limit=Allowance().answer)


def test_limits_grow_with_the_file():
    small, large = limits_for(0), limits_for(20_000_000)
    assert large.memory > small.memory + 20_000_000
    assert large.seconds > small.seconds + 20.0


@linux
def test_each_call_has_the_limits_of_its_own_file(reader):
    for size in (0, 3_000_000, 1000):
        memory, space, seconds, used = reader.call(f"{HERE}:limits_here", about="x", size=size)
        own = limits_for(size)
        assert (memory, space) == (own.memory, own.memory + (1 << 30))
        # A limit is in whole seconds, of all that the child has used so far.
        assert own.seconds - 0.1 <= seconds - used <= own.seconds + 1.1


def test_an_exception_of_a_library_is_a_fault_of_the_file_and_developers_see_where(reader, caplog):
    caplog.set_level("DEBUG")
    assert said(reader.call, f"{HERE}:fail", "library") == (
        "'x.mat' cannot be read: ZeroDivisionError: of a library; the file may be damaged"
    )
    assert "decoders.py" in caplog.text


def test_a_caller_that_knows_better_says_what_to_do(reader):
    assert said(reader.call, f"{HERE}:fail", "library", advice="save it again").endswith("of a library; save it again")


def test_who_goes_on_for_longer_says_so(monkeypatch):
    monkeypatch.setattr("mjsim.guarded.guarded_reader.limits_for", lambda size: Allowance(seconds=1.0))
    with Reader(f"{HERE}:same") as reader:
        assert reader.call(f"{HERE}:work", 4, 0.4, about="x") == 4


def test_errors_of_mjsim_pass():
    with Reader(f"{HERE}:same") as reader:
        assert said(reader.call, f"{HERE}:fail", "usage") == "of a usage"
        with pytest.raises(RecordingError, match="of a recording"):
            reader.call(f"{HERE}:fail", "recording", about="x")
        with pytest.raises(WorldError) as caught:
            reader.call(f"{HERE}:wrong_world", about="x")
    assert str(caught.value) == "room.yaml:2:3: height is -2.0 m; it must be above 0"


@pytest.mark.parametrize("function", ["missing_library", "object_of_own"])
def test_a_mistake_of_ours_is_no_fault_of_the_file(reader, function):
    with pytest.raises(RuntimeError, match="the reader of 'x' has a bug"):
        reader.call(f"{HERE}:{function}", about="x")


def test_no_valid_answer_is_one_line_and_ends_the_child(reader):
    before = reader.call(f"{HERE}:process", about="x")
    assert "its reader gave no valid answer" in said(reader.call, f"{HERE}:forged")
    assert reader.call(f"{HERE}:process", about="x") != before


@linux
@pytest.mark.parametrize("what", decoders.ATTEMPTS)
def test_a_decoder_reaches_nothing_else(reader, tmp_path, what):
    place = tmp_path / "secret"
    place.write_text("secret")
    assert reader.call(f"{HERE}:attempt", what, str(place), about="x") is not None
    assert place.read_text() == "secret"


@linux
def test_the_same_attempts_succeed_without_it(tmp_path):
    for number, what in enumerate(["read", "list", "append", "change mode", "write", "link"]):
        place = tmp_path / f"{number}"
        place.write_text("secret")
        assert decoders.attempt(what, str(place)) is None


def test_no_descriptor_or_variable_of_the_parent_reaches_the_child(tmp_path, monkeypatch):
    monkeypatch.setenv("SECRET", "key")
    with (tmp_path / "open").open("w") as file:
        os.set_inheritable(file.fileno(), True)
        assert guarded(f"{HERE}:descriptors", about="x") == []
        assert guarded("os:getenv", "SECRET", about="x") is None


def test_a_temporary_file_needs_a_scratch_folder_and_goes_with_the_child(reader):
    with Reader(f"{HERE}:same", scratch=True) as writer:
        text, name = writer.call(f"{HERE}:temporary", "text", about="x")
        assert text == "text"
        folder = Path(name).parent
        assert folder.is_dir()
    assert not folder.exists()
    assert "cannot be read" in said(reader.call, f"{HERE}:temporary", "text")


@pytest.mark.slow
@linux
@pytest.mark.parametrize("sign", [signal.SIGINT, signal.SIGKILL])
def test_the_child_ends_with_its_parent(sign):
    code = (
        "from mjsim.guarded import Reader\n"
        "with Reader('tests.guarded.decoders:same') as reader:\n"
        "    print(reader.call('tests.guarded.decoders:process', about='x'), flush=True)\n"
        "    reader.call('tests.guarded.decoders:hang', about='x')\n"
    )
    command = [sys.executable, "-c", code]
    with child(command) as parent:
        reader = int(parent.line())
        parent.send(sign)
        parent.ended()
        until = time.monotonic() + 10.0
        while Path(f"/proc/{reader}").exists() and time.monotonic() < until:
            time.sleep(0.01)
        assert not Path(f"/proc/{reader}").exists()


@pytest.mark.parametrize("answer", [1, {"problems": [1]}, {"problems": [["a", "b", 1, "c"]]}, {"error": []}])
def test_answers_of_another_form_are_one_line(answer):
    with Reader(f"{HERE}:lie") as reader:
        reader.call(f"{HERE}:lie", answer, about="x")
        assert "its reader gave no valid answer" in said(reader.call, f"{HERE}:same", 1)


@pytest.mark.slow
def test_a_child_that_takes_no_further_call_is_ended():
    with Reader(f"{HERE}:deaf") as reader:
        reader.call(f"{HERE}:deaf", about="x")
        parts = reader.parts(f"{HERE}:same", bytes(1 << 20), about="x", limits=Allowance(seconds=0.3))
        with pytest.raises(UsageError, match="it took longer than"):
            next(parts)
