"""How long it takes to start, in multiples of what NumPy takes."""

import runpy
import statistics
from pathlib import Path

import pytest

from tests import ONE_THREAD

START = runpy.run_path(str(Path(__file__).parents[1] / "scripts" / "measure" / "start.py"))
SPARE = 1.2
"""Machines differ in what NumPy takes beside all else."""
FEW, MANY = 1, 25
"""Rounds: processor time wanders on a loaded machine, and the first writes bytecode: where few say no, more decide."""


@pytest.mark.slow
@pytest.mark.parametrize("case", START["MOST"])
def test_starting_takes_few_times_what_numpy_takes(case, monkeypatch):
    for name in ONE_THREAD:  # NumPy starts its threads, as for users
        monkeypatch.delenv(name)
    most = SPARE * START["MOST"][case]
    commands = [START["CASES"][name] for name in ("import numpy", case)]
    ratios = []
    while len(ratios) < FEW or (len(ratios) < MANY and statistics.median(ratios) > most):
        numpy, ours = (START["once"](command, cpu=True) for command in commands)
        ratios.append(ours / numpy)
    assert statistics.median(ratios) <= most
