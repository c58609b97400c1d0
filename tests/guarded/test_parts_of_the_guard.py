"""Pieces of the guarded reader by themselves: limits, answers, the form of values, the filter of system calls."""

import errno
import io
import json
import os
import pickle
import struct
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from mjsim.errors import Problem, RecordingError, UsageError, WorldError
from mjsim.guarded import landlock, syscalls
from mjsim.guarded.child import answers_to
from mjsim.guarded.landlock import read_only
from mjsim.guarded.limits import Allowance, limits_for
from mjsim.guarded.lockdown import LIBRARIES, memory_limits
from mjsim.guarded.plain_values import HEAD_DIVISOR, WireError, receive, send
from mjsim.guarded.request import Call
from mjsim.guarded.seccomp import program, refuse_calls
from mjsim.guarded.working import MISSING, REPORT, in_child, missing_limits, still_working
from mjsim.sentences import Sentence


def crossed(value: object) -> object:
    file = io.BytesIO()
    send(file, value)
    file.seek(0)
    return receive(file, limit=1 << 20)


@pytest.mark.parametrize(
    "value",
    [None, True, 3, -2.5, "ä\n", b"\0\xff", [1, [2]], (1, (2, "x")), {"a": 1, 2: (3,)}, {}, (), [b"", b"1"], 2**80],
)
def test_plain_values_cross_as_they_are(value):
    found = crossed(value)
    assert (found, type(found)) == (value, type(value))


def test_sentences_cross_with_their_templates_and_values():
    inner = Sentence("its unit is {unit:g} m", 1e9)
    (found,) = crossed([Sentence("'{path}' cannot be read: {why}", "a.obj", inner)])
    assert found == "'a.obj' cannot be read: its unit is 1e+09 m"
    assert (found.template, found.values["why"].template) == ("'{path}' cannot be read: {why}", "its unit is {unit} m")


@pytest.mark.parametrize("template", ["{why.__class__}", "{why!r}", "{why:>9}", "{0}", "{other}", "{"])
def test_a_template_that_asks_for_more_than_its_values_does_not_cross(template):
    value = {"sentence": [template, {"dict": [["why", "it is"], ["0", "x"]]}]}
    with pytest.raises(WireError):
        receive(message(json.dumps({"value": value, "buffers": []}).encode()), limit=1 << 20)


@pytest.mark.parametrize("kind", ["?", "<u2", ">i4", "<f4", ">f8"])
def test_arrays_cross_in_any_order_of_bytes_and_memory(kind):
    array = np.arange(12).reshape(3, 4).astype(kind)
    for each in (array, array.T, array[::2, 1:], array[:0], np.array(5).astype(kind)):
        found = crossed({"x": [each]})["x"][0]
        np.testing.assert_array_equal(found, each)
        assert (found.shape, found.dtype) == (each.shape, each.dtype.newbyteorder("="))


@pytest.mark.parametrize("value", [object(), {1, 2}, np.array(["a"]), np.array([None]), 1j])
def test_other_types_do_not_cross(value):
    with pytest.raises(TypeError, match="cannot be handed back; make it text, numbers or an array"):
        crossed([value])


def message(head: bytes, *buffers: bytes) -> io.BytesIO:
    return io.BytesIO(struct.pack("<Q", len(head)) + head + b"".join(buffers))


@pytest.mark.parametrize(
    "head",
    [
        b"not json",
        b'{"value": 1}',
        b'{"value": {"bytes": 0}, "buffers": []}',
        b'{"value": {"bytes": -1}, "buffers": [1]}',
        b'{"value": {"a": 1, "b": 2}, "buffers": []}',
        b'{"value": {"other": 1}, "buffers": []}',
        b'{"value": 1, "buffers": [-1]}',
        b'{"value": 1, "buffers": [1.5]}',
        b'{"value": 1, "buffers": [600, 600]}',
        b'{"value": {"array": [0, "<f4", [2]]}, "buffers": [4]}',
        b'{"value": {"array": [0, "|O", [1]]}, "buffers": [8]}',
        b'{"value": {"array": [0, "<U1", [1]]}, "buffers": [4]}',
        b'{"value": {"array": [0, "<f4", [-1, -1]]}, "buffers": [4]}',
        b'{"value": {"array": [0, "|u1", [' + b",".join([b"1"] * 33) + b']]}, "buffers": [1]}',
    ],
)
def test_messages_of_another_form_are_refused(head):
    with pytest.raises(WireError):
        receive(message(head, bytes(1200)), limit=1024 * (1 if len(head) < 64 else HEAD_DIVISOR))


def test_a_message_is_as_long_as_allowed_and_no_longer():
    head = b'{"value": {"bytes": 0}, "buffers": [1024]}'
    limit = max(1024, HEAD_DIVISOR * len(head))
    assert receive(message(head, bytes(1024)), limit=limit) == bytes(1024)
    with pytest.raises(WireError, match="a head of 42 bytes"):
        receive(message(head, bytes(1024)), limit=HEAD_DIVISOR * len(head) - 1)
    with pytest.raises(EOFError):
        receive(message(head, bytes(1023)), limit=limit)
    with pytest.raises(EOFError):
        receive(io.BytesIO(b"123"), limit=limit)


def test_limits_are_those_of_the_size():
    small, large = limits_for(0), limits_for(2_000_000)
    assert (small.memory, small.seconds) == (768 << 20, 14.0)
    assert (large.memory - small.memory, large.seconds - small.seconds) == (128_000_000, 20.0)
    assert small.answer == small.memory // 3
    (_, private), (_, mapped) = memory_limits(small)
    assert (private, mapped - private) == (small.memory, LIBRARIES)


@pytest.mark.parametrize(
    "keys", [{"memory": 0}, {"seconds": 0.0}, {"seconds": float("inf")}, {"written": 0}, {"memory": -1}]
)
def test_limits_are_above_0(keys):
    with pytest.raises(ValueError, match="both must be above 0"):
        Allowance(**keys)


def call(name: str, *arguments: object, folder: Path | None = None, **keywords: object) -> list[dict]:
    fields = {"function": f"{__name__}:{name}", "arguments": arguments, "keywords": keywords, "folder": folder}
    return [dict(each) for each in answers_to(pickle.dumps(Call(**fields)))]


def failing(kind: str) -> None:
    problem = Problem("w.yaml", 3, 7, "wrong")
    raise {
        "world": WorldError([problem]),
        "usage": UsageError("say it otherwise"),
        "recording": RecordingError("cut"),
        "system": FileNotFoundError(errno.ENOENT, "No such file"),
        "library": KeyError("a"),
        "silent": AssertionError(),
        "memory": MemoryError(),
        "missing": ImportError("no module"),
    }[kind]


def counted(count: int, *, end: str = "") -> object:
    yield from range(count)
    if end:
        failing(end)


@pytest.mark.parametrize(
    ("kind", "answer"),
    [
        ("world", {"error": "WorldError", "problems": [["w.yaml", 3, 7, "wrong"]]}),
        ("usage", {"error": "UsageError", "message": "say it otherwise"}),
        ("recording", {"error": "RecordingError", "message": "cut"}),
        ("system", {"failed": "No such file"}),
        ("library", {"failed": "KeyError: 'a'"}),
        ("silent", {"failed": "AssertionError"}),
        ("memory", {"memory": True}),
        ("missing", {"fault": "no module"}),
    ],
)
def test_errors_in_the_child_are_described_for_the_parent(kind, answer):
    (found,) = call("failing", kind)
    said = found.pop("traceback", "Error")
    assert found == answer
    assert "Error" in said.splitlines()[-1]


def test_a_value_comes_whole_and_of_a_generator_in_parts():
    assert call("counted", 2) == [{"part": 0}, {"part": 1}, {"value": None}]
    *parts, last = call("counted", 2, end="usage")
    assert (parts, last["error"]) == ([{"part": 0}, {"part": 1}], "UsageError")
    assert call("in_folder") == [{"value": str(Path.cwd())}]


def in_folder() -> str:
    return str(Path.cwd())


def test_a_call_runs_in_its_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(Path.cwd())  # it is back afterwards
    assert call("in_folder", folder=tmp_path) == [{"value": str(tmp_path)}]


def test_what_runs_in_the_child_tells_that_it_works():
    told = []
    assert (in_child(), list(missing_limits())) == (False, [])
    still_working()
    report, missing = REPORT.set(lambda: told.append(1)), MISSING.set(("memory",))
    try:
        still_working()
        assert (in_child(), missing_limits(), told) == (True, ["memory"], [1])
    finally:
        REPORT.reset(report)
        MISSING.reset(missing)


def verdict(code: Sequence[tuple[int, int, int, int]], machine: int, call: int, *arguments: int) -> int:
    """Return what the filter says of a system call: 0 if allowed, or the error number (BPF by its manual)."""
    data = struct.pack("<IIQ6Q", call, machine, 0, *arguments, *[0] * (6 - len(arguments)))
    value, at = 0, 0
    while True:
        operation, if_true, if_false, operand = code[at]
        at += 1
        if operation == 0x20:  # load a word
            (value,) = struct.unpack_from("<I", data, operand)
        elif operation == 0x06:  # return
            return 0 if operand == 0x7FFF0000 else operand & 0xFFFF
        else:
            holds = {0x15: value == operand, 0x35: value >= operand, 0x45: value & operand != 0}[operation]
            at += if_true if holds else if_false


MACHINES = {"x86_64": 0xC000003E, "aarch64": 0xC00000B7}
OPENED = {"x86_64": 257, "aarch64": 56}
OTHERS = {
    "x86_64": {"clone": 56, "tgkill": 234, "prlimit": 302},
    "aarch64": {"clone": 220, "tgkill": 131, "prlimit": 261},
}


@pytest.mark.parametrize("machine", MACHINES)
@pytest.mark.parametrize("writing", [False, True])
def test_the_filter_refuses_what_a_decoder_does_not_need(machine, writing):
    code, audit = program(machine, writing=writing), MACHINES[machine]
    for table in (syscalls.REFUSED, syscalls.ATTRIBUTES, syscalls.WRITING):
        for call in table.values():
            number = call.x86_64 if machine == "x86_64" else call.aarch64
            if number is not None:
                allowed = writing and table is syscalls.WRITING
                assert verdict(code, audit, number) == (0 if allowed else call.error)
    # Reading, and mapping memory.
    for number in (0, 9) if machine == "x86_64" else (63, 222):
        assert verdict(code, audit, number) == 0
    assert verdict(code, 0x40000003, 0) == errno.ENOSYS
    assert verdict(code, audit, 0x40000000) == (errno.ENOSYS if machine == "x86_64" else 0)


@pytest.mark.parametrize("machine", MACHINES)
def test_the_filter_looks_at_arguments(machine):
    code, audit, other = program(machine, writing=False), MACHINES[machine], OTHERS[machine]
    for flags in (os.O_RDONLY, os.O_RDONLY | os.O_CLOEXEC | os.O_DIRECTORY):
        assert verdict(code, audit, OPENED[machine], 3, 1 << 40, flags) == 0
    for flags in (os.O_WRONLY, os.O_RDWR, os.O_CREAT, os.O_TRUNC, os.O_APPEND):
        assert verdict(code, audit, OPENED[machine], 3, 1 << 40, flags) == errno.EACCES
        assert verdict(program(machine, writing=True), audit, OPENED[machine], 3, 1 << 40, flags) == 0
    if machine == "x86_64":
        assert verdict(code, audit, 2, 1 << 40, os.O_RDONLY) == 0
        assert verdict(code, audit, 2, 1 << 40, os.O_CREAT) == errno.EACCES
    # Threads, not processes; signals to itself; limits are read, not set.
    assert verdict(code, audit, other["clone"], 0x00010000 | 0x100) == 0
    assert verdict(code, audit, other["clone"], 0x11) == errno.EPERM
    assert verdict(code, audit, other["tgkill"], os.getpid()) == 0
    assert verdict(code, audit, other["tgkill"], os.getpid() + 1) == errno.EPERM
    assert verdict(code, audit, other["prlimit"], 0, 7, 0) == 0
    for place in (1, 1 << 32):
        assert verdict(code, audit, other["prlimit"], 0, 7, place) == errno.EPERM


@pytest.mark.parametrize(("key", "value"), [("platform", "darwin"), ("byteorder", "big"), ("maxsize", 2**31 - 1)])
def test_other_systems_have_no_filter(monkeypatch, key, value):
    monkeypatch.setattr(sys, key, value)
    assert not refuse_calls(writing=False)
    if key == "platform":
        assert not read_only([Path("/")])


def test_a_folder_that_is_not_there_is_left_out_of_what_may_be_read(tmp_path):
    class Libc:
        def __init__(self) -> None:
            self.asked = []

        def syscall(self, *words: object) -> int:
            self.asked.append(words)
            return 0

    (tmp_path / "file").touch()
    libc = Libc()
    for place in (tmp_path / "none", tmp_path, tmp_path / "file"):
        landlock._allow(libc, 5, place, 0b1100)
    # A file has no right to list a folder.
    rights = [struct.unpack("<Qi", words[3])[0] for words in libc.asked]
    assert [words[:3] for words in libc.asked] == [(445, 5, 1)] * 2
    assert rights == [0b1100, 0b0100]
