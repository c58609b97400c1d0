"""Logs are read in a guarded child: what harms it is one line, and what it sends is checked."""

import contextlib
import itertools
import os
import signal
from pathlib import Path

import pytest
from mcap.reader import make_reader

import mjsim
from mjsim.errors import MjsimError, UsageError
from mjsim.guarded import Reader
from mjsim.logs.files.csv_table import read_csv
from mjsim.logs.files.number_table import read_table
from mjsim.logs.files.text_lines import lines_of
from mjsim.logs.importing import limits_of, put_together
from mjsim.logs.resampling.record_output import Output
from mjsim.logs.resampling.wishes import Wishes
from mjsim.record import reserve_whole
from tests.logs import hostile
from tests.real_logs import imported, write_mrclam


def _messages(path: Path) -> list[tuple[str, int, bytes]]:
    """Return topic, time and data of the messages of a recording but those that tell wall-clock time."""
    with path.open("rb") as file:
        found = make_reader(file).iter_messages()
        return [(at.topic, message.log_time, message.data) for _, at, message in found if at.topic != "/timing"]


@pytest.mark.slow
def test_a_recording_from_the_child_is_that_of_this_process(tmp_path):
    write_mrclam(tmp_path / "log", seconds=20.0)
    done: list[float] = []
    mjsim.import_log(tmp_path / "log", record=tmp_path / "child.mcap", progress=done.append)
    imported(tmp_path / "log", record=tmp_path / "here.mcap")
    assert _messages(tmp_path / "child.mcap") == _messages(tmp_path / "here.mcap")
    assert done == sorted(done)
    assert done[-1] == 100.0


ENDS = {
    "carmen_bomb": "unpacks to more than 20 times its size",
    "one_line_bomb": "is not a supported log",
    "dictionary_of_a_gigabyte": "it needs more than",
    "mrclam_bomb": "unpacks to more than 20 times its size",
    "table_bomb": "unpacks to more than 20 times its size",
    "one_line_of_columns": "unpacks to more than 20 times its size",
    "deep_description": "nested more than 50 deep",
    "many_aliases": "more than 250000 values",
    "outside_by_a_link": "inputs.dat:1: ",  # here it leads to what the child may read
    "pipe_for_a_table": "it is not a file",
    "pipe_for_a_list": "is not a supported log",
    "pipe_for_euroc": "is not a supported log",
    "links_in_a_circle": "is not a supported log",
    "mcap_of_bombs": "there is nothing to record",
    "bag_of_bombs": "is not a readable bag",
    "messages_without_end": "is not a readable bag",
    "topics_without_end": "is not a readable bag",
    "messages_of_a_gigabyte": "is not a readable bag",
    "metadata_names_others": "is not a readable bag",
    "packed_database_bomb": "is not a readable bag",
    "archive": "is an archive; unpack it",
    "stamps_past_all_numbers": "numbers must be finite",
    "ranges_past_all_numbers": "numbers must be finite",
    "numbers_of_a_million_digits": "run.log:1: ",
}
"""Maker of a log that is refused -> part of its line; the others come in, without what they claim."""
SLOW = {
    *(
        "carmen_bomb",
        "mrclam_bomb",
        "victoria_park_bomb",
        "table_bomb",
        "one_line_of_columns",
        "dictionary_of_a_gigabyte",
    ),
    *("mcap_of_bombs", "bag_of_bombs", "metadata_of_brackets", "one_line_bomb", "deep_description"),
}


@pytest.fixture(scope="module")
def child(tmp_path_factory):
    with Reader("mjsim.logs.log_kinds:convert", folders=[tmp_path_factory.getbasetemp()], scratch=True) as reader:
        yield reader


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] if name in SLOW else []) for name in hostile.HOSTILE]
)
def test_a_log_made_to_harm_is_one_line_or_comes_in_without_its_claims(name, child, tmp_path):
    path, said = hostile.HOSTILE[name](tmp_path), ""
    arguments = "mjsim.logs.importing:sent", "mjsim.logs.log_kinds:convert", path, Wishes(), ""
    try:
        for _ in child.parts(*arguments, about=path, limits=limits_of(path)):
            pass
    except MjsimError as error:
        said = str(error)
    assert said.isprintable()
    assert ENDS.get(name, "") in said
    assert bool(said) == (name in ENDS)


@pytest.mark.slow
def test_a_link_that_leads_out_of_a_log_is_not_followed(tmp_path):
    with pytest.raises(UsageError, match=r"Permission denied"):
        mjsim.import_log(hostile.outside_by_a_link(tmp_path), record=tmp_path / "run.mcap")
    assert not (tmp_path / "run.mcap").exists()


@pytest.mark.slow
def test_a_child_that_is_killed_on_its_way_is_one_line_and_leaves_no_file(tmp_path):
    write_mrclam(tmp_path / "log", seconds=100.0)
    mine = Path("/proc/self/task")

    def kill(percent: float) -> None:
        for child in (word for task in mine.iterdir() for word in (task / "children").read_text().split()):
            if b"mjsim.guarded" in Path("/proc", child, "cmdline").read_bytes():
                with contextlib.suppress(ProcessLookupError):
                    os.kill(int(child), signal.SIGKILL)

    with pytest.raises(UsageError, match="its reader crashed"):
        mjsim.import_log(tmp_path / "log", record=tmp_path / "run.mcap", progress=kill)
    assert [each.name for each in tmp_path.iterdir()] == ["log"]


@pytest.mark.parametrize(
    "part",
    [
        None,
        (50.0,),
        ("half", []),
        (float("nan"), []),
        (50.0, [(-1, b"x")]),
        (50.0, [(1 << 40, b"x")]),
        (50.0, [(0, "x")]),
        (50.0, [0]),
        (50.0, {"x": 1}),
    ],
)
def test_what_is_no_part_of_a_recording_is_refused(part, tmp_path):
    with reserve_whole(tmp_path / "run.mcap") as place, pytest.raises(UsageError, match="gave no valid answer"):
        list(put_together([(1.0, [(0, b"whole"), (5, b"")]), part], Output(place, ""), limit=1000))
    assert not list(tmp_path.iterdir())


def test_parts_of_a_recording_are_put_where_they_belong(tmp_path):
    with reserve_whole(tmp_path / "run.mcap") as place:
        parts = [(1.0, [(0, b"0123456789")]), (100.0, [(2, b"ab"), (10, b"end")])]
        assert list(put_together(parts, Output(place, ""), limit=1000)) == [1.0, 100.0]
    assert (tmp_path / "run.mcap").read_bytes() == b"01ab456789end"


@pytest.mark.parametrize("place", [0, None])
def test_a_recording_that_grows_without_end_is_refused(place, tmp_path):
    parts = ((1.0, [(20 * number if place is None else place, bytes(20))]) for number in itertools.count())
    with reserve_whole(tmp_path / "run.mcap") as whole, pytest.raises(UsageError, match="too large for the size"):
        list(put_together(parts, Output(whole, ""), limit=100))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("suffix", [".gz", ".xz", ".bz2"])
def test_a_text_that_unpacks_to_too_much_is_refused_and_a_long_one_is_read(suffix, tmp_path, monkeypatch):
    monkeypatch.setattr("mjsim.logs.files.text_lines.MIN_UNPACKED_LIMIT", 1 << 20)
    path = hostile.packed(tmp_path / f"run.log{suffix}", bytes(4095) + b"\n", 3)
    with pytest.raises(UsageError, match="unpacks to more than 20 times its size; unpack it yourself"):
        list(lines_of(path))
    (tmp_path / "run.log").write_bytes(hostile.ODOM * 50_000)
    assert len(list(lines_of(tmp_path / "run.log"))) == 50_000


def test_a_log_of_days_without_readings_is_refused_before_it_is_written(tmp_path):
    (tmp_path / "odometry.csv").write_text("t,x,y,heading\n0,0,0,0\n1,0.1,0,0\n900000,0.2,0,0\n")
    (tmp_path / "log.yaml").write_text(
        "log: tables\nodometry: {file: odometry.csv, time: t, x: x, y: y, heading: heading}\n"
    )
    with pytest.raises(UsageError, match="lasts 900000 s and has 3 readings; a recording of them lasts at most"):
        imported(tmp_path / "log.yaml", record=tmp_path / "run.mcap")


def test_a_quotation_mark_that_is_not_closed_is_said(tmp_path):
    (tmp_path / "o.csv").write_text('t,x\n0,1\n1,"2\n2,3\n')
    with pytest.raises(UsageError, match="a quotation mark that is not closed in its line"):
        read_csv(tmp_path / "o.csv")


@pytest.mark.slow
def test_a_number_whose_square_overflows_is_named_with_its_line(tmp_path):
    (tmp_path / "inputs.dat").write_text("0 1 0\n1 1e200 0\n")
    with pytest.raises(UsageError, match=r"inputs\.dat:2: velocity is '1e200'; it must be at most"):
        read_table(tmp_path / "inputs.dat", ("time", "velocity", "steering"))
