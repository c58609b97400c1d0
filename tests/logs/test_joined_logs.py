"""CARMEN logs one after the other in a file, the second of which began earlier or much later."""

import numpy as np
import pytest

import mjsim
from tests.real_logs import imported


def _lines(begin: float, x: float, *, count: int = 40) -> list[str]:
    """Return a log of a robot that drives 0.5 m/s along x, whose odometry comes later than its scans."""
    lines = []
    for k in range(count):
        at, place = begin + 0.1 * k, x + 0.05 * k
        scan = " ".join(["2.5"] * 180)
        lines.append(f"FLASER 180 {scan} {place} 1 0 {place} 1 0 {at} host {at - begin}")
        lines.append(f"ODOM {place - 0.04} 1 0 0.5 0 0 {at - 0.08} host {at - begin}")
    return lines


@pytest.mark.parametrize(("begin", "said"), [(7.0, "set back 1 times"), (190_000.0, "set back 0 times and ahead")])
def test_a_log_behind_another_goes_on_from_there(begin, said, tmp_path):
    path = tmp_path / "both.clf"
    path.write_text("\n".join([*_lines(90_000.0, 3.0), *_lines(begin, 40.0)]) + "\n")
    run = imported(path)
    assert run.metadata["clock"].startswith(f"mended: {said}")
    moved = np.array([seen.odometry.forward for seen in run.observations("robot")])
    assert 7.9 < run.time[-1] < 8.4
    assert moved.min() >= 0.0
    np.testing.assert_allclose(moved.sum(), 2 * 1.95, atol=0.15)
    assert sum(bool(seen.scans) for seen in run.observations("robot")) == 80


def test_messages_that_come_late_set_no_clock(tmp_path):
    path = tmp_path / "late.clf"
    lines = _lines(90_000.0, 3.0)
    # Half a second of odometry that was written two seconds late.
    path.write_text("\n".join([*lines[:21], *lines[31:71], *lines[21:31], *lines[71:]]) + "\n")
    run = imported(path)
    assert "clock" not in run.metadata
    assert run.time[-1] < 4.1


@pytest.mark.parametrize(
    ("count", "given", "span"), [(200, "0.5", 99.5), (181, "7", 180.0), (683, None, 682 * 360 / 1024)]
)
def test_beams_are_apart_as_the_laser_or_the_log_says(count, given, span, tmp_path):
    path = tmp_path / "log.clf"
    scans = [f"FLASER {count} {' '.join(['2.5'] * count)} 0 0 0 0 0 0 {0.1 * k} host 0" for k in range(3)]
    path.write_text("\n".join([f"PARAM laser_front_laser_resolution {given} nohost 0"] * bool(given) + scans) + "\n")
    scan = next(seen.scans["front"] for seen in imported(path).observations("robot") if seen.scans)
    assert np.degrees(np.ptp(scan.angles())) == pytest.approx(span)


def test_a_number_whose_square_overflows_is_refused(tmp_path):
    path = tmp_path / "log.clf"
    path.write_text("\n".join(f"ODOM {x} 0 0 0 0 0 {1.0 + 0.1 * k} host 0" for k, x in enumerate([0, 0.1, 1e308, 0.3])))
    with pytest.raises(
        mjsim.UsageError, match=r"log\.clf:3: ODOM holds '1e\+308'; numbers must be finite, and at most"
    ):
        imported(path)
