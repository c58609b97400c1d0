"""Text logs that were cut: as files, and as compressed ones."""

import bz2
import gzip
import lzma
import math
from pathlib import Path

import numpy as np
import pytest

from mjsim.errors import UsageError
from mjsim.logs import Wishes
from tests.real_logs import imported

PACKERS = {".gz": gzip.compress, ".xz": lzma.compress, ".bz2": lambda data: bz2.compress(data, 1)}


def table(rows: int) -> str:
    """Return odometry along x, 0.1 m a row, with 12 digits, which do not compress well."""
    digits = np.random.default_rng(0).integers(10**11, 10**12, rows).tolist()
    return "t,x,y,h\n" + "".join(f"{0.1 * k:.1f},{0.1 * k:.1f},0.{digits[k]},0.25\n" for k in range(rows))


def described(folder: Path, name: str) -> Path:
    """Return a description of a table."""
    log = folder / "log.yaml"
    log.write_text(f"log: tables\nodometry: {{file: {name}, time: t, x: x, y: y, heading: h}}\n")
    return log


@pytest.mark.slow
@pytest.mark.parametrize("kind", PACKERS)
def test_a_compressed_table_that_was_cut_is_read_up_to_its_last_whole_line(kind, tmp_path):
    rows = 20_000  # bzip2 unpacks whole blocks of 100 kB only.
    data = PACKERS[kind](table(rows).encode())
    (tmp_path / f"o.csv{kind}").write_bytes(data[: len(data) // 2])
    log = described(tmp_path, f"o.csv{kind}")
    run = imported(log, wishes=Wishes(begin=1.0, seconds=1.0))
    assert run.metadata[f"o.csv{kind} breaks off"].startswith("left out: the compressed file was cut")
    from mjsim.logs.files.csv_table import read_csv

    notes: dict[str, str] = {}
    found = read_csv(tmp_path / f"o.csv{kind}", notes=notes)
    whole = table(rows).splitlines()[1:]
    assert 0.2 * rows < len(found.rows) < 0.8 * rows
    assert [",".join(row) for row in found.rows] == whole[: len(found.rows)]
    with pytest.raises(UsageError, match="cannot unpack"):
        read_csv(tmp_path / f"o.csv{kind}")


def test_a_compressed_log_of_which_nothing_is_left_is_said_to_be_cut(tmp_path):
    (tmp_path / "run.log.bz2").write_bytes(bz2.compress(table(100).encode())[:-20])
    with pytest.raises(UsageError, match=r"no log in the part that could be unpacked \(the compressed file was cut"):
        imported(tmp_path / "run.log.bz2")


def test_the_last_line_of_a_table_that_was_cut_is_left_out_and_reported(tmp_path):
    (tmp_path / "o.csv").write_text(table(30)[:-20])
    run = imported(described(tmp_path, "o.csv"))
    assert run.metadata["last line of o.csv, cut short, left out"] == "1"
    assert sum(math.hypot(seen.odometry.forward, seen.odometry.left) > 0 for seen in run.observations("robot")) == 28


@pytest.mark.parametrize("file", ["Robot1_Odometry.dat", "Robot1_Measurement.dat", "Robot1_Groundtruth.dat"])
def test_a_file_of_mrclam_whose_last_line_was_cut_is_read(file, tmp_path):
    (tmp_path / "Barcodes.dat").write_text("1 5\n6 63\n")
    (tmp_path / "Landmark_Groundtruth.dat").write_text("6 2 1 0.001 0.001\n")
    texts = {
        "Robot1_Groundtruth.dat": "".join(f"{0.01 * k} {0.002 * k} 0.0 0.0\n" for k in range(400)),
        "Robot1_Odometry.dat": "".join(f"{0.02 * k} 0.2 0.0\n" for k in range(200)),
        "Robot1_Measurement.dat": "".join(f"{0.5 * k} 63 {2.0 - 0.1 * k} 0.5\n" for k in range(8)),
    }
    for name, text in texts.items():
        (tmp_path / name).write_text(text if name != file else text[: text.rindex(" ")])
    run = imported(tmp_path)
    assert run.metadata[f"last line of {file}, cut short, left out"] == "1"
    (tmp_path / file).write_text(texts[file].replace("0.0\n", "\n", 1).replace("0.5\n", "\n", 1))
    with pytest.raises(UsageError, match=rf"{file}:\d+: \d values"):
        imported(tmp_path)
