"""Fast reading: what the C parser sees is what the exact one sees, of worlds, of malformed texts and of wild ones."""

import time
from importlib import resources

import numpy as np
import pytest

from mjsim.errors import WorldError
from mjsim.world import parse_world
from mjsim.world.yaml.scan import END, OTHER, SCALAR, UnsureError, YamlEvent, exact_events, fast_events
from tests.world.malformed import TEXTS

SHIPPED = {
    file.name: file.read_text(encoding="utf-8")
    for file in resources.files("mjsim.worlds").iterdir()
    if file.name.endswith(".yaml")
}
SMALL = [*SHIPPED.values(), *(text for text, _ in TEXTS.values() if len(text) < 5000)]
SIGNS = (
    *(" ", "\n", "\n  ", "\n- ", ": ", ":", "-", "- ", "? ", "#", " #", ", ", "[", "]", "{", "}", '"', "'", "|", ">"),
    *("&a ", "*a ", "!", "!!str ", "%", "@", "`", "\t", "a", "0", ".5", "\\", "\\x41", "\\u263a", "\\\n", "\r\n", "\r"),
    *(
        "é",
        "\u2028",
        "\x85",
        "~",
        "<<",
        "=",
        "---",
        "...",
        "😀",
        "\xa0",
        "\ufeff",
        "''",
        '""',
        "1:2",
        "{}",
        "[]",
        ">-\n ",
    ),
)
"""What wild texts are made of."""


def steps(events) -> list[YamlEvent]:
    """Return the events of a text; where a list ends does not matter to anybody."""
    return [event for event in events if event.kind not in (END, OTHER)]


def compare(text: str) -> bool:
    """Say whether the fast parser is sure of a text, having checked that it then sees what the exact one does."""
    try:
        fast = steps(fast_events(text))
    except UnsureError:
        return False
    assert fast == steps(exact_events(text))
    return True


def wild(rng: np.random.Generator) -> str:
    """Return a few lines of a world with signs strewn in, or signs alone."""
    if rng.random() < 0.5:
        return "".join(rng.choice(SIGNS, rng.integers(1, 15)))
    lines = SMALL[rng.integers(len(SMALL))].splitlines(keepends=True) or [""]
    first = rng.integers(len(lines))
    text = "".join(lines[first : first + rng.integers(1, 6)])
    for place in rng.integers(0, len(text) + 1, rng.integers(0, 4)).tolist():
        text = text[:place] + rng.choice(SIGNS) + text[place + int(rng.choice([0, 0, 1, 3])) :]
    return text


@pytest.mark.slow
@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_worlds_are_read_fast_and_as_ever(name):
    assert compare(SHIPPED[name])


@pytest.mark.slow
def test_malformed_texts_are_seen_alike_or_left_to_the_exact_parser():
    sure = [compare(text) for text in SMALL]
    assert sum(sure) > len(SMALL) / 2


@pytest.mark.slow
def test_wild_texts_are_seen_alike_or_left_to_the_exact_parser():
    rng = np.random.default_rng(3)
    assert sum(compare(wild(rng)) for _ in range(1000)) > 200


@pytest.mark.slow
def test_many_wild_texts_are_seen_alike_or_left_to_the_exact_parser():
    rng = np.random.default_rng(4)
    assert sum(compare(wild(rng)) for _ in range(5_000)) > 1000


@pytest.mark.parametrize(
    "text", ["&a b", "a: *b", "!x y", "a: |\n b", "\ta", "%YAML 1.1\n---\na", "a\n...\nb", "a:", "? a"]
)
def test_what_the_parsers_may_see_differently_is_left_to_the_exact_one(text):
    assert not compare(text)


def test_plain_texts_are_not_left_to_it():
    # Signs that mean something else elsewhere: arithmetic, a colour, a path, an address.
    assert compare(
        "a: ['${w*2}', \"${w & 3}\", '#fff', b!c, d|e, f>g]\ng: ${w*2}\nh: i?j\n'k': \"l\\u0041\"\n# & * ! | >\n"
    )


@pytest.mark.slow
def test_a_text_is_read_many_times_as_fast():
    walls = "\n".join(f"- {{points: [[{k}, 0], [{k}, 5.25]], thickness: 0.12}}" for k in range(300))

    def seconds(events) -> float:
        began = time.process_time()
        assert sum(event.kind == SCALAR for event in events(f"walls:\n{walls}\n")) > 2000
        return time.process_time() - began

    pairs = [(seconds(exact_events), seconds(fast_events)) for _ in range(2)]
    # 20 on an idle machine.
    assert max(exact / fast for exact, fast in pairs) > 6


@pytest.mark.slow
def test_a_fault_in_a_large_world_has_its_place():
    lines = [f"- points: [[{k}, 0], [{k}, 5]]\n" for k in range(2000)]
    lines[1500] = "- points: [[0, 0], [0, x]]\n"
    with pytest.raises(WorldError) as caught:
        parse_world("walls:\n" + "".join(lines))
    assert str(caught.value) == "world.yaml:1502:24: points[1][1] is 'x'; it must be a number"
