"""docs/licences.md names every package whose licence asks more than a notice, and what its wheel carries."""

import importlib.metadata
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest
from packaging.requirements import Requirement

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "licences.md").read_text()
ROWS = dict(re.findall(r"^\| `([\w-]+)`[^|]* \| (.+) \|$", PAGE, re.MULTILINE))
"""Package -> the rest of its row."""
ASKING = re.compile(r"GPL|Lesser|MPL|Mozilla|EPL|Eclipse|TOST|CDDL|Affero")
"""Licences that ask for more than that their notice is kept."""
CARRIED = re.compile(r"\blib(x264|x265|geos|avcodec|mp3lame|gnutls|unistring)\b")
"""Libraries in wheels under such licences."""


KINDS = ("LGPL", "MPL-2.0", "EPL-2.0", "TOST-1.0", "GPLv3", "BSD", "Apache")


def packages() -> Iterator[str]:
    """Yield the installed packages that mjsim and its extras need, and what these need."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    waiting = [
        *project["dependencies"],
        *(each for extra in project["optional-dependencies"].values() for each in extra),
    ]
    known: set[str] = set()
    while waiting:
        needed = Requirement(waiting.pop())
        name = re.sub(r"[-_.]+", "-", needed.name).lower()
        if name in known or not (needed.marker is None or needed.marker.evaluate({"extra": ""})):
            continue
        known.add(name)
        try:
            waiting += importlib.metadata.requires(name) or []
        except importlib.metadata.PackageNotFoundError:
            continue  # an extra that this machine does without
        yield name


def licence_of(name: str) -> str:
    """Return how the metadata of a package names its licence; of a whole text the first line."""
    found = importlib.metadata.metadata(name)
    kinds = [kind for kind in found.get_all("Classifier") or () if kind.startswith("License")]
    named = found.get("License-Expression") or (found.get("License") or "").strip().partition("\n")[0]
    return " ".join([named, *kinds])


def carried_by(name: str) -> set[str]:
    """Return the libraries of `CARRIED` in the wheel of a package."""
    return {found[1] for file in importlib.metadata.files(name) or () if (found := CARRIED.search(file.name))}


@pytest.mark.slow
def test_every_licence_that_asks_for_more_is_on_the_page_and_no_other():
    installed = set(packages())
    asking = {name for name in installed if ASKING.search(licence_of(name)) or carried_by(name)}
    assert asking == ROWS.keys() & installed
    assert {"av", "qpsolvers"} <= asking


@pytest.mark.parametrize("name", sorted(ROWS))
def test_a_row_names_the_licence_of_the_package_and_what_its_wheel_carries(name):
    try:
        licence = licence_of(name)
    except importlib.metadata.PackageNotFoundError:
        pytest.skip(f"{name} is not installed")
    own, _, carried = ROWS[name].partition(" | ")
    assert {kind for kind in KINDS if kind in own} == {kind for kind in KINDS if kind in licence}
    assert all(f"lib{library}" in carried for library in carried_by(name))
