"""The classes that a world may name are names of `mjsim.algorithms`, each loaded when it is first used."""

import importlib
import sys
from pathlib import Path

import pytest

import mjsim.algorithms
from mjsim.modules import offers_in
from tests.children import completed

FOLDER = Path(mjsim.algorithms.__file__).parent
FILES = [(path, path.stem) for path in sorted(FOLDER.glob("*.py"))]
PACKAGED = [(path, path.parent.name) for path in sorted(FOLDER.glob("*/*.py"))]


def test_each_class_that_a_world_may_name_is_a_name_of_the_package():
    offered = dict(reversed(offer.use.split(":")) for offer in offers_in([*FILES, *PACKAGED]))
    assert len(offered) > 30
    assert sorted(mjsim.algorithms.__all__) == sorted(offered)
    places = sorted(pair[::-1] for pair in offered.items())
    lines = "".join(f"from .{module} import {name} as {name}\n" for module, name in places)
    assert (FOLDER / "__init__.pyi").read_text() == lines


@pytest.mark.parametrize("name", ["EkfSlam", "Waypoints", "BeaconVision"])
def test_it_is_the_class_of_its_module(name):
    made = getattr(mjsim.algorithms, name)
    assert made is getattr(importlib.import_module(made.__module__), name)


@pytest.mark.slow
def test_one_class_loads_its_own_module_alone():
    code = "import sys; from mjsim.algorithms import Waypoints; print('mjsim.algorithms.ekf_slam' in sys.modules)"
    assert completed([sys.executable, "-c", code]).stdout == "False\n"
