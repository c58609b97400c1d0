"""Mistakes that modules make, and what the line about each says."""

from pathlib import Path
from typing import Any

import pytest
from ruamel.yaml import YAML

from tests.modules.faulty import written

TABLES = Path(__file__).parents[1] / "data" / "mistakes"
STARTED = [
    # What goes wrong before the first tick: role, the file, what the line says after 'at 0.00 s'.
    ("estimator", written("estimator", "", start="1 / 0"), r"raised ZeroDivisionError: .* \(bad\.py:\d+\)"),
    ("navigator", written("navigator", "", start="sys.exit(4)"), r"raised SystemExit: 4 \(bad\.py:\d+\)"),
    (
        "estimator",
        written("estimator", "").replace("robot, catalogue, rng", "robot"),
        r"raised TypeError: Bad\.start\(\) takes 2 positional arguments but 4 were given \(bad\.py:\d+\)",
    ),
    (
        "navigator",
        written("navigator", "").replace("class Bad:", "class Bad:\n    def take_map(self, map): map.segments[:] = 0"),
        r"raised ValueError: .* copy them first \(bad\.py:\d+\)",
    ),
    (
        "observer",
        written("observer", "").replace("class Bad:", "class Bad:\n    take_map = property(lambda self: 1 / 0)"),
        r"raised ZeroDivisionError: .* \(bad\.py:\d+\)",
    ),
    (
        "observer",
        written("observer", "", start="catalogue.clear()"),
        r"raised TypeError: inputs of a module are read-only; copy them first \(bad\.py:\d+\)",
    ),
    (
        "estimator",
        written("estimator", "yield"),
        r"returned a value of type generator; it must be an Estimate \(bad\.py:\d+\)",
    ),
]


def mistakes_in(name: str) -> Any:
    """Return a table of mistakes by the name of its file."""
    return YAML(typ="safe").load(TABLES / name)


def cases() -> list:
    """Return (role, module, what its line says) of all mistakes."""
    table = mistakes_in("python.yaml")
    late = [
        (case["role"], written(case["role"], case["body"]), f"at 0.20 s .*{case['says']}")
        for case in (*table["raised"], *table["returned"])
    ]
    early = [(role, text, f"at 0.00 s .*{says}") for role, text, says in STARTED]
    return [pytest.param(role, text, says, id=f"{role}-{says[12:60]}") for role, text, says in (*late, *early)]
