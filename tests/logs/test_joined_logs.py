"""CARMEN logs one after the other in a file, the second of which began earlier."""

import numpy as np

import mjsim


def _lines(begin: float, x: float, *, count: int = 40) -> list[str]:
    """Return a log of a robot that drives 0.5 m/s along x, whose odometry comes later than its scans."""
    lines = []
    for k in range(count):
        at, place = begin + 0.1 * k, x + 0.05 * k
        scan = " ".join(["2.5"] * 180)
        lines.append(f"FLASER 180 {scan} {place} 1 0 {place} 1 0 {at} host {at - begin}")
        lines.append(f"ODOM {place - 0.04} 1 0 0.5 0 0 {at - 0.08} host {at - begin}")
    return lines


def test_a_log_behind_a_later_one_goes_on_from_there(tmp_path):
    path = tmp_path / "both.clf"
    path.write_text("\n".join([*_lines(90_000.0, 3.0), *_lines(7.0, 40.0)]) + "\n")
    run = mjsim.import_log(path)
    assert run.metadata["clock"].startswith("set back 1 times")
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
    run = mjsim.import_log(path)
    assert "clock" not in run.metadata
    assert run.time[-1] < 4.1
