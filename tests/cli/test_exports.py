"""`mjsim export` prints the names of what it wrote."""

from pathlib import Path

import pytest

from tests.cli.shell import typed


@pytest.mark.slow
def test_an_export_prints_files_that_are_there(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("two.yaml").write_text(
        "mjsim: 1\nrobots: [{name: a, at: [0, 0]}, {name: b, at: [2, 0]}]\nrun: {drivers: {a: {}, b: {}}}\n"
    )
    assert typed("run", "two.yaml", "--seconds", "0.2", "-o", "run.mcap", capsys=capsys)[0] == 0
    words = ("export", "run.mcap", "--tum", "tum", "--npz", "run.npz", "--carmen", "run.log")
    code, out, _ = typed(*words, capsys=capsys)
    assert (code, out) == (0, "tum\nrun.npz\nrun_a.log\nrun_b.log\n")
    assert all(Path(name).exists() for name in out.split())
