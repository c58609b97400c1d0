import random
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import foxglove
import numpy as np
import pytest
from mcap.reader import make_reader

from mjsim.errors import ModuleFault, RecordingError, UsageError
from mjsim.record import Recorder, Recording, RobotEvent, Tick, read_recording
from tests.children import child, completed
from tests.record_ticks import DT, hand_made_ticks, hand_made_world, infos, record

TICKS = 60


@pytest.fixture(scope="module")
def ticks() -> list[Tick]:
    return list(hand_made_ticks(TICKS))


@pytest.fixture(scope="module")
def recording(ticks: list[Tick], tmp_path_factory: pytest.TempPathFactory) -> Recording:
    return read_recording(record(tmp_path_factory.mktemp("record") / "run.mcap", ticks))


def read_or_none(path: Path) -> Recording | None:
    """Return what a broken file holds; when that is nothing, the reason must be one line."""
    if not path.exists():
        return None
    try:
        return read_recording(path)
    except RecordingError as error:
        if "\n" in str(error):
            raise
        return None


@pytest.mark.slow
def test_a_truncated_file_gives_all_records_before_the_cut(recording: Recording, tmp_path: Path):
    contents = recording.path.read_bytes()
    chooser, counts = random.Random(0), []
    for place in sorted(chooser.sample(range(1, len(contents)), 25)):
        cut = tmp_path / "cut.mcap"
        cut.write_bytes(contents[:place])
        read = read_or_none(cut)
        if read is None:
            counts.append(0)
            continue
        assert not read.whole
        n = len(read.time)
        counts.append(n)
        np.testing.assert_array_equal(read.time, recording.time[:n])
        np.testing.assert_array_equal(read.robots["scout"].estimate, recording.robots["scout"].estimate[:n])
        assert all(image.shape == (48, 64, 3) for _, image in read.images("scout", "front"))
    assert counts == sorted(counts)
    assert counts[-1] == TICKS


@pytest.mark.slow
def test_a_broken_byte_loses_only_the_data_after_it(recording: Recording, tmp_path: Path):
    contents = bytearray(recording.path.read_bytes())
    chooser = random.Random(1)
    for place in chooser.sample(range(100, len(contents)), 20):
        broken = contents.copy()
        broken[place] ^= 0x55
        path = tmp_path / "broken.mcap"
        path.write_bytes(broken)
        read = read_or_none(path)
        if read is not None:
            np.testing.assert_array_equal(read.qpos, recording.qpos[: len(read.time)])


@pytest.mark.parametrize(
    ("contents", "message"),
    [(b"", "is empty"), (b"mjsim: 1\nname: room\n", "is not an MCAP file"), (b"\x89MCAP", "is not an MCAP file")],
)
def test_a_file_that_is_not_a_recording_is_a_one_line_error(tmp_path: Path, contents: bytes, message: str):
    path = tmp_path / "run.mcap"
    path.write_bytes(contents)
    with pytest.raises(RecordingError, match=message) as caught:
        read_recording(path)
    assert "\n" not in str(caught.value)


def test_a_missing_file_a_folder_and_a_foreign_mcap_are_refused_in_one_line(tmp_path: Path):
    with pytest.raises(UsageError, match=r"no file '.*none.mcap'; name a recording"):
        read_recording(tmp_path / "none.mcap")
    with pytest.raises(UsageError, match="is a folder; name a recording"):
        read_recording(tmp_path)
    context = foxglove.Context()
    with foxglove.open_mcap(tmp_path / "foreign.mcap", context=context):
        foxglove.Channel("/a", context=context).log({"b": 1}, log_time=0)
    with pytest.raises(RecordingError, match="not a recording made by mjsim"):
        read_recording(tmp_path / "foreign.mcap")
    short = record(tmp_path / "short.mcap", hand_made_ticks(1))
    with short.open("r+b") as file:
        summary = make_reader(file).get_summary()
        assert summary is not None
        file.truncate(summary.chunk_indexes[0].chunk_start_offset)
    with pytest.raises(RecordingError, match="holds no tick"):
        read_recording(short)


ROOT = Path(__file__).parents[2]

KILLED = """
import sys, time
from tests.record_ticks import *
from mjsim.record import Recorder
recorder = Recorder(sys.argv[1], world=hand_made_world(), seed=5, robots=infos(), metadata={})
for k, tick in enumerate(hand_made_ticks(10**6)):
    recorder.write(tick)
    print(k, flush=True)
    time.sleep(0.025)
"""


@pytest.mark.slow
def test_a_run_that_is_killed_loses_less_than_its_last_second(tmp_path: Path):
    path = tmp_path / "run.mcap"
    command = [sys.executable, "-c", KILLED, str(path)]
    with child(command, cwd=ROOT) as process:
        while int(process.line()) < 30:
            pass
        process.kill()
        written = 30 + process.rest().count("\n")
    read = read_recording(path)
    assert not read.whole
    assert written - len(read.time) <= 1.0 / DT
    assert len(read.time) > 0
    first = list(hand_made_ticks(len(read.time)))
    np.testing.assert_array_equal(read.qpos, [tick.qpos for tick in first])


def test_what_is_written_reaches_the_file_while_the_loop_rests(tmp_path: Path, ticks: list[Tick]):
    path = tmp_path / "run.mcap"
    with Recorder(path, world=hand_made_world(), seed=5, robots=infos(), metadata={}) as recorder:
        for tick in ticks[:3]:
            recorder.write(tick)
        ends = time.monotonic() + 60.0
        while (read := read_or_none(path)) is None and time.monotonic() < ends:
            time.sleep(0.02)
        assert read is not None
        assert len(read.time) == 3


def test_ctrl_c_leaves_a_whole_file(tmp_path: Path, ticks: list[Tick]):
    def interrupted() -> Iterator[Tick]:
        yield from ticks[:10]
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        record(tmp_path / "run.mcap", interrupted())
    read = read_recording(tmp_path / "run.mcap")
    assert read.whole
    assert len(read.time) == 10


FULL = """
import resource, signal, sys
from tests.record_ticks import *
from mjsim.errors import RecordingError
from mjsim.record import Recorder
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
for path, room in zip(sys.argv[1:], (60_000, 100)):
    resource.setrlimit(resource.RLIMIT_FSIZE, (room, 60_000))
    try:
        with Recorder(path, world=hand_made_world(), seed=5, robots=infos(), metadata={}) as recorder:
            for tick in hand_made_ticks(10**6):
                recorder.write(tick)
    except RecordingError as error:
        print(error)
"""


@pytest.mark.slow
def test_a_disk_that_fills_or_is_full_ends_the_run_with_one_line_and_leaves_what_was_written(tmp_path: Path):
    paths = [tmp_path / name for name in ("fills.mcap", "full.mcap")]
    done = completed([sys.executable, "-Wdefault", "-c", FULL, *map(str, paths)], cwd=ROOT)
    assert done.stdout == "".join(f"cannot write '{path}': File too large\n" for path in paths)
    assert done.stderr == ""
    assert len(read_recording(paths[0]).time) > 0


def test_a_place_where_nothing_can_be_written_is_refused_at_once(tmp_path: Path):
    (tmp_path / "file").write_text("")
    with pytest.raises(UsageError, match=r"'.*file' exists and is not a folder; name another one"):
        record(tmp_path / "file" / "run.mcap", [])
    with pytest.raises(RecordingError, match=r"cannot write '/proc/none/run.mcap': "):
        record(Path("/proc/none/run.mcap"), [])


def test_nan_in_a_tick_is_refused_with_its_topic_and_time(tmp_path: Path, ticks: list[Tick]):
    spoilt = replace(ticks[2], qvel=np.full(12, np.nan))
    with pytest.raises(RecordingError, match=r"/state at 0.080 s holds NaN"):
        record(tmp_path / "run.mcap", [*ticks[:2], spoilt])
    assert len(read_recording(tmp_path / "run.mcap").time) == 2


@pytest.mark.slow
def test_nothing_is_lost_when_the_writer_is_slower_than_the_loop(tmp_path: Path):
    path = record(tmp_path / "run.mcap", hand_made_ticks(8, size=(960, 1280)))
    recording = read_recording(path)
    assert len(recording.time) == 8
    assert sum(1 for _ in recording.pictures("scout", "front")) == 4


def test_a_fault_outside_of_a_tick_is_in_the_events(tmp_path: Path, ticks: list[Tick]):
    path, fault = tmp_path / "run.mcap", RobotEvent(3 * DT, "fault", "estimator raised ValueError")

    def failing() -> None:
        with Recorder(path, world=hand_made_world(), seed=1, robots=infos(), metadata={}) as recorder:
            for tick in ticks[:3]:
                recorder.write(tick)
            recorder.event("scout", fault)
            raise ModuleFault("estimator raised")

    with pytest.raises(ModuleFault, match="estimator raised"):
        failing()
    recording = read_recording(path)
    assert recording.whole
    assert recording.robots["scout"].events == (fault,)
    assert len(recording.time) == 3
