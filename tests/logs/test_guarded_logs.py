"""Logs are read in a guarded child: what harms it is one line, and what it sends is checked."""

import contextlib
import itertools
import os
import signal
from pathlib import Path

import pytest
from mcap.reader import make_reader

import mjsim
from mjsim.errors import UsageError
from mjsim.logs.csv_table import read_csv
from mjsim.logs.importing import put_together
from mjsim.logs.output import Output
from mjsim.logs.table import read_table
from mjsim.logs.text import lines_of
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
    write_mrclam(tmp_path / "log", seconds=200.0)
    done: list[float] = []
    mjsim.import_log(tmp_path / "log", record=tmp_path / "child.mcap", progress=done.append)
    imported(tmp_path / "log", record=tmp_path / "here.mcap")
    assert _messages(tmp_path / "child.mcap") == _messages(tmp_path / "here.mcap")
    assert done == sorted(done)
    assert done[-1] == 100.0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("make", "said"),
    [
        (hostile.messages_of_a_gigabyte, "run.db3"),
        (hostile.outside_by_a_link, "Permission denied"),
    ],
)
def test_a_log_that_swells_or_leads_elsewhere_is_one_line(make, said, tmp_path):
    path = make(tmp_path)
    with pytest.raises(UsageError, match=said) as caught:
        mjsim.import_log(path, record=tmp_path / "run.mcap")
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "run.mcap").exists()


@pytest.mark.slow
def test_a_child_that_is_killed_on_its_way_is_one_line_and_leaves_no_file(tmp_path):
    write_mrclam(tmp_path / "log", seconds=200.0)
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
    monkeypatch.setattr("mjsim.logs.text.UNPACKED", 1 << 20)
    path = hostile.packed(tmp_path / f"run.log{suffix}", bytes(4095) + b"\n", 3)
    with pytest.raises(UsageError, match="unpacks to more than 100 times its size; unpack it yourself"):
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


def test_a_number_whose_square_overflows_is_named_with_its_line(tmp_path):
    (tmp_path / "inputs.dat").write_text("0 1 0\n1 1e200 0\n")
    with pytest.raises(UsageError, match=r"inputs\.dat:2: velocity is '1e200'; it must be at most"):
        read_table(tmp_path / "inputs.dat", ("time", "velocity", "steering"))
