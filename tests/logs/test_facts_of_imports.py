"""Small facts of imported logs: pieces put together, limits, parts, names, origins."""

import numpy as np
import pytest

from mjsim.errors import RecordingError, UsageError
from mjsim.logs import data_sets
from mjsim.logs.importing import limits_of as limits_of_log
from mjsim.logs.importing import put_together
from mjsim.logs.resampling.origin import near_origin
from mjsim.logs.resampling.record_output import Output, SentFile
from mjsim.logs.resampling.resample import MotionNoise
from mjsim.logs.resampling.robot_log import RobotLog
from mjsim.logs.resampling.ticks import cut, name_from


def test_pieces_of_a_recording_are_handed_on_in_order(tmp_path):
    sent = SentFile(tmp_path / "a.mcap")
    file = sent.opened()
    assert [file.write(memoryview(data)) for data in (b"head", b"body")] == [4, 4]
    assert file.seek(0, 0) == 0
    file.write(memoryview(b"HE"))
    assert (file.seek(1, 1), file.seek(0, 2), file.seek(-1, 2)) == (3, 8, 7)
    file.write(memoryview(b"Yend"))
    assert sent.waiting == 14
    assert sent.taken() == [(0, b"headbody"), (0, b"HE"), (7, b"Yend")]
    assert (sent.waiting, sent.taken()) == (0, [])
    file.write(memoryview(b"!"))
    sent.publish()
    sent.close()
    assert sent.taken() == [(11, b"!")]


@pytest.mark.parametrize(
    ("parts", "error", "said"),
    [
        ([(50.0, [(0, b"abcd"), (2, b"C")]), (100.0, [(4, b"e")])], None, b"abCde"),
        ([(101.0, [])], UsageError, "gave no valid answer"),
        ([(-1.0, [])], UsageError, "gave no valid answer"),
        ([(1, [])], UsageError, "gave no valid answer"),
        ([(1.0, [(1, b"a")])], UsageError, "gave no valid answer"),  # a hole
        ([(1.0, [(-1, b"a")])], UsageError, "gave no valid answer"),
        ([(1.0, ["a"])], UsageError, "gave no valid answer"),
        ([(1.0, [(0, b"x" * 11)])], UsageError, "too large for the size of the log"),
        ([(1.0, [(0, b"x" * 10)])], None, b"x" * 10),
    ],
)
def test_what_a_child_sends_is_put_together_or_refused(tmp_path, parts, error, said):
    from mjsim.record import reserve_whole

    path = tmp_path / "a.mcap"
    with reserve_whole(path) as place:
        if error is not None:
            with pytest.raises(error, match=said):
                list(put_together(parts, Output(place, ""), limit=10))
        else:
            assert list(put_together(parts, Output(place, ""), limit=10)) == [done for done, _ in parts]
    assert path.exists() == (error is None)
    assert error is not None or path.read_bytes() == said


def test_a_disk_that_is_full_ends_an_import_in_one_line(tmp_path):
    class Full(SentFile):
        def write(self, data: memoryview) -> int:
            raise OSError(28, "No space left on device")

        def seek(self, offset: int, whence: int = 0) -> int:
            return offset

    with pytest.raises(RecordingError, match=r"cannot write '.*a.mcap': No space left"):
        list(put_together([(1.0, [(0, b"a")])], Output(Full(tmp_path / "a.mcap"), ""), limit=10))


def test_limits_of_a_log_grow_with_its_files(tmp_path):
    (tmp_path / "log.yaml").write_bytes(b"1" * 10)
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "a.csv").write_bytes(b"1" * 1_000_000)
    whole, alone = limits_of_log(tmp_path), limits_of_log(tmp_path / "in" / "a.csv")
    assert whole.seconds - alone.seconds == pytest.approx(10.0 * (10 + (tmp_path / "in").stat().st_size) / 1e6)
    assert limits_of_log(tmp_path / "log.yaml").seconds == whole.seconds
    assert alone.seconds == pytest.approx(24.0)
    assert alone.written > 1_000_000


@pytest.mark.parametrize(
    ("begin", "seconds", "found"),
    [(0.0, None, (10.0, 20.0)), (2.0, None, (12.0, 20.0)), (2.0, 3.0, (12.0, 15.0)), (5.0, 9.0, (15.0, 20.0))],
)
def test_a_part_of_a_log_is_cut_out(begin, seconds, found):
    assert cut(10.0, 20.0, begin=begin, seconds=seconds, rate_hz=10.0) == found


def test_a_part_has_two_ticks():
    assert cut(10.0, 20.0, begin=9.75, seconds=None, rate_hz=4.0) == (19.75, 20.0)
    with pytest.raises(UsageError, match=r"0.2 s of a log of 10 s remain; two ticks are 0.25 s apart"):
        cut(10.0, 20.0, begin=9.8, seconds=None, rate_hz=4.0)
    with pytest.raises(UsageError, match="some files of the log end at 10 s, before others begin, at 20 s"):
        cut(20.0, 10.0, begin=0.0, seconds=None, rate_hz=4.0)


def test_names_of_logs_are_names_of_worlds(tmp_path):
    assert [name_from(tmp_path / name) for name in ("my log.bag", "-.a", "ä", "x" * 99)] == [
        "my-log.bag", "a", "log", "x" * 64,
    ]  # fmt: skip


def test_a_truth_far_away_is_moved_to_a_near_origin():
    near = RobotLog(truth=np.array([[0.0, 10_000.0, -10_000.0, 1.0]]))
    logs, marks, note = near_origin([near], [{"a": (1.0, 2.0)}])
    assert (logs, marks, note) == ([near], [{"a": (1.0, 2.0)}], "")
    rows = np.array([[0.0, np.nan, np.nan, 0.5], [1.0, 456_789.0, -5_432_101.0, 0.5]])
    (moved,), marks, note = near_origin([RobotLog(truth=rows)], [{"a": (456_800.0, -5_432_000.0)}])
    assert moved.truth[1].tolist() == [1.0, 89.0, 99.0, 0.5]
    assert rows[1, 1] == 456_789.0
    assert marks == [{"a": (100.0, 200.0)}]
    assert note == "x 456700, y -5432200 m of the log, whose coordinates are too large for a world"
    poses = np.array([[0.0, 20_050.0, 0.0, 3.0, 0.0, 0.0, 0.0, 1.0]])
    (moved,), _, _ = near_origin([RobotLog(poses=poses)], [])
    assert moved.poses.tolist() == [[0.0, 50.0, 0.0, 3.0, 0.0, 0.0, 0.0, 1.0]]
    assert (moved.truth, near_origin([], [{}])) == (None, ([], [{}], ""))


def test_options_of_data_sets_reach_their_reader(monkeypatch):
    asked = []
    monkeypatch.setattr(data_sets, "guarded_recording", lambda *words, **keys: asked.append((words, keys)))
    noise = MotionNoise(distance=0.1, turn=0.2, veer=0.3, aside=0.05)
    data_sets.import_mrclam("d", robots=[1, 3], rate_hz=5.0, begin=1.0, seconds=2.0, known_map=True, motion=noise,
                            sighting=(0.4, 0.5), record="r.mcap", overwrite=True)  # fmt: skip
    data_sets.import_victoria_park("d", rate_hz=6.0, begin=3.0, seconds=4.0)
    (first, keys), (second, plain) = asked
    assert (first[0], second[0]) == (
        "mjsim.logs.formats:convert_mrclam",
        "mjsim.logs.formats:convert_victoria_park",
    )
    wishes = first[2]
    assert (wishes.rate_hz, wishes.begin, wishes.seconds, list(wishes.robots), wishes.known_map) == (
        5,
        1,
        2,
        ["1", "3"],
        True,
    )
    assert dict(wishes.motion) == {"distance": 0.1, "turn": 0.2, "veer": 0.3, "aside": 0.05}
    assert (wishes.range_noise, wishes.bearing_noise) == (0.4, 0.5)
    assert (keys["record"], keys["overwrite"], plain["record"], plain["overwrite"]) == ("r.mcap", True, None, False)
    wishes = second[2]
    assert (wishes.rate_hz, wishes.begin, wishes.seconds) == (6, 3, 4)
    assert (dict(wishes.motion), wishes.range_noise, wishes.bearing_noise) == ({}, None, None)
