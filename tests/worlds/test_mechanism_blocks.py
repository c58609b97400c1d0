"""Each block of SimMechanics is in a world that runs, or refused with a line that says what to use instead."""

import re
from pathlib import Path

import pytest

import mjsim
from mjsim.errors import WorldError
from mjsim.world.items.mechanisms.mechanism_items import INSTEAD

ROOT = Path(mjsim.__file__).parent.parent
PAGE = (ROOT / "docs" / "mechanisms.md").read_text(encoding="utf-8").partition("## Blocks")[2].partition("\n## ")[0]
ROWS = [row for line in PAGE.splitlines()[8:] if len(row := tuple(c.strip() for c in line[1:-1].split("|"))) == 3]
RUNS = [(block, key, world) for block, key, world in ROWS if world]
REFUSED = [re.findall(r"`(.*?)`", key)[0] for _, key, world in ROWS if not world]
BODY = (
    "mjsim: 1\nmechanisms:\n  - {name: m, bodies: [{name: b, sphere: 1%s}], joints: [{weld: w, of: [ground, b]}]%s}\n"
)


def test_the_table_holds_all_blocks():
    assert len(ROWS) > 40
    assert sorted(REFUSED) == sorted(key for _, key in INSTEAD)


@pytest.mark.parametrize("world", sorted({world for *_, world in RUNS}))
def test_what_the_table_says_is_in_a_world_is_there(world):
    text = (ROOT / "worlds" / "mechanisms" / f"{world}.yaml").read_text(encoding="utf-8")
    for block, key, where in RUNS:
        words = re.findall(r"[a-z_]+", " ".join(re.findall(r"`(.*?)`", key)))
        assert where != world or not words or any(word in text for word in words), block


@pytest.mark.parametrize("key", REFUSED)
def test_what_is_refused_is_refused_with_what_to_use_instead(key):
    part = next((part for part, name in INSTEAD if name == key), "constraints")
    own = f", {key}: 1" if part == "bodies" else ""
    others = "" if part == "bodies" else f", {part}: [{{{key}: b}}]"
    with pytest.raises(WorldError, match=r"^w.yaml:3:\d+: .*(;|join) .*$"):
        mjsim.parse_world(BODY % (own, others), file="w.yaml")
