"""Values written for a world file read back as they are."""

import math

import numpy as np

from mjsim.world import read_text
from mjsim.world.edit.snippet import _number as number_text

RNG = np.random.default_rng(6)
NUMBERS = [0.0, 1.0, -3.0, 1e15, -1e18, 0.1, 1e-3, 123456.789, 1e-12, 5e-13, math.inf, -math.inf, math.pi]
NUMBERS += (10.0 ** RNG.uniform(-14.0, 17.0, 60) * RNG.choice([-1.0, 1.0], 60)).tolist()


def test_a_number_reads_back_as_it_is():
    for value in NUMBERS:
        node, problems = read_text(f"a: {number_text(value)}\n", file="a.yaml")
        assert not problems
        assert float(node.value["a"]) == value


def test_no_number_is_written_as_none_and_whole_ones_without_a_point():
    node, _ = read_text(f"a: {number_text(math.nan)}\n", file="a.yaml")
    assert math.isnan(node.value["a"])
    assert [number_text(value) for value in (3.0, -2.0, 0.25, 1e-3, 2e-5)] == ["3", "-2", "0.25", "0.001", "0.00002"]
