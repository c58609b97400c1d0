"""Read thousands of hostile world files: each must be valid, or refused with the place of each error.

Each world that is read is also formatted, as by `mjsim fmt`, and written back with a change.

python scripts/fuzz/worlds.py [--inputs 100000] [--seed 1] [--engine changed|built|bytes|all]

'changed' takes the shipped worlds and changes lines, numbers and characters; 'built' lets hypothesis build trees of
known keys with wild values; 'bytes' lets atheris follow the coverage of the reader over raw bytes. The first input
that ends in a traceback, or takes longer than a limit, is written to out/fuzz and ends the script with exit code 1.
"""

import argparse
import json
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import seed as hypothesis_seed
from hypothesis import strategies as st

from mjsim.errors import MjsimError
from mjsim.modules import check_modules, load_runnable
from mjsim.world import format_world, world_schema
from mjsim.world.edit.formatter import format_text

LIMIT = 5.0
"""Maximum processor time of an input [s]."""
SHORT = 2000
"""Every input of at most this length is formatted, of longer ones every tenth [characters]."""
ROOT = Path(__file__).resolve().parents[2]
WILD = (
    *("0", "-1", "1e400", "-0.0", "1e-320", ".nan", ".inf", "null", "true", "~", "''", "[]", "{}", "[[]]", "9" * 40),
    *("*a", "&a x", "!!binary AA==", "0x1F", "2026-01-02", "12:30", "a" * 300, "\u202e", "é", "\ud7ff", "\t"),
    *("${w}", "${1/0}", "${9**9**9}", "${", "${${w}}", "../up.png", "/etc/passwd", "<<: {a: 1}", "- x", "? y", "#"),
    *("|", ">-", "%YAML 1.1", "---", "...", "[1, 2", "}", "'", '"'),
    *("{repeat: {times: 1000000}}", "{times: 100000, offset: [0, 0]}", "{times: 300}", "[{times: 99}, {times: 99}]"),
    *("[hall.yaml]", "[parts/room.yaml]", "[world.yaml]", "[hall.yaml, hall.yaml]", "hall.yaml", "lion.jpg"),
    *('"${w}"', '"${i + j}"', '"${a ** b}"', '"${sqrt(w - 9)}"', '"$${"', "${w / 2} m", "<<"),
)
"""Replacements for values, in text."""
VALUES: tuple[Any, ...] = (
    *(0, 1, -1, 2.5, 1e308, -1e-308, 10**30, True, None, [], {}, [0, 0], [1, 2, 3], [[0, 0], [4, 0]]),
    *("", "a", "a b", "é", "${w}", "${w * 2}", "${i}", "${q}", "posters/lion.jpg", "../x", "#ffffff", "front"),
    *("scout", "pioneer3dx", "mjsim.algorithms.waypoints:Waypoints", ["hall.yaml"], ["parts/room.yaml", "hall.yaml"]),
    *({"times": 3}, {"times": 2, "offset": [1, 0]}, [{"times": 2}, {"times": "${w}", "offset": [0, 1]}], {"w": 3}),
    *({"times": 2, "offset": 0.5}, {"times": 5, "turn_deg": 30, "about": [1, 1]}, "${i + j / w}", "${1 / 0}", "a-${k}"),
)
"""Replacements for values, as values."""
REUSED = (
    """\
include: [hall.yaml, parts/room.yaml]   # both
variables: {w: 6, a: 2, b: "${w ** a / 10}", paint: "#ffeedd"}
name: hall-${w}
obstacles:
  - {name: "rack-${i}-${j}", box: [1, "${w / 6}", 0.5], at: ["${i}", 1], color: "${paint}",
     repeat: [{times: 3, offset: [0, 2]}, {times: "${a}", offset: [1.5, 0]}]}
  - {name: post, cylinder: [0.1, 2], at: [9, 5], repeat: {times: 8, turn_deg: 45, about: [5, 5]}}
lamps: [{at: [1, 1], repeat: {times: 4, offset: [2, 0]}}]
floor: {patches: [{at: [1, 1], size: [1, "${min(w, 1)}"], repeat: {times: 2, offset: [2, 0]}}]}
run: {seconds: "${w * 2}", events: [{time: "${i * 3}", light: "${1 - i / 4}", repeat: {times: 4}}]}
""",
    """\
mjsim: 1
variables:
  n: 3
walls:
  - points: [[0, 0], [12, 0], ["${4 * n}", 8]]
    repeat: {times: "${n}", offset: [0, 3]}
    openings:
      - {name: door, at: 0.5, width: 0.9, repeat: {times: 2, offset: 1.5}}   # two doors in each
robots:
  - name: r
    at: [2, 1.5]
    repeat: {times: 2, offset: [0, 3]}
    sensors: [{camera: c, yaw_deg: "${90 * j}", at: [0.1, 0, 1], repeat: {times: 4, turn_deg: 90, about: [0, 0]}}]
beacons: [{name: b, "on": "r-${i + 1}", at: [0, 0], repeat: {times: 2}}]
""",
)
"""Worlds that include, compute and repeat."""
BESIDE = {
    "hall.yaml": 'variables: {w: 4, h: "${w / 2}"}\nwalls: [{points: [[0, 0], ["${w}", 0]], height: "${h}"}]\n',
    "parts/room.yaml": "include: [../hall.yaml]\nbeacons: [{name: lion, image: lion.jpg, at: [1, 1]}]\n",
}
"""World files beside the one that is read."""


class WorldTrial:
    """Reads inputs one after the other, and remembers the slowest."""

    def __init__(self, folder: Path) -> None:
        self.count, self.worlds, self.laid, self.slowest, self.last = 0, 0, 0, 0.0, b""
        self._file = folder / "world.yaml"
        (folder / "parts").mkdir(exist_ok=True)
        for name, text in BESIDE.items():
            (folder / name).write_text(text, encoding="utf-8")
        shutil.copy(ROOT / "assets" / "posters" / "lion.jpg", folder / "parts")

    def read(self, data: bytes) -> None:
        """Read an input as `mjsim check` does, and write it back when it is a world.

        Raises:
            TimeoutError: It took too long.
        """
        self.count, self.last = self.count + 1, data
        self._file.write_bytes(data)
        start = time.process_time()
        self._told(self._read)
        if len(data) < SHORT or self.count % 10 == 0:
            self._told(lambda: self._lay_out(data))
        taken = time.process_time() - start
        self.slowest = max(self.slowest, taken)
        if taken > LIMIT:
            raise TimeoutError(f"reading took {taken:.1f} s")

    def _read(self) -> None:
        world = load_runnable(self._file)
        check_modules(world)
        self.worlds += 1
        format_world(world.model_copy(update={"name": "fuzz"}))

    def _lay_out(self, data: bytes) -> None:
        text = data.decode("utf-8", "replace")
        laid = format_text(text, file="world.yaml")
        self.laid += 1
        assert format_text(laid, file="world.yaml") == laid, "laid out twice it is another text"

    def _told(self, what: Callable[[], None]) -> None:
        """Perform an action that may fail with messages of one line each."""
        try:
            what()
        except MjsimError as error:
            said = str(error)
            # One line a fault: nothing of a traceback, nothing that breaks a terminal.
            if not said or not all(line.isprintable() for line in said.splitlines()):
                raise AssertionError(f"this is not a line for a person: {said!r}") from error


def seeds() -> list[str]:
    """Return the shipped worlds, and small ones that include, compute and repeat."""
    files = sorted((ROOT / "worlds").rglob("*.yaml"))
    shipped = [file.read_text(encoding="utf-8") for file in files if file.stat().st_size < 20_000]
    return [*shipped, *REUSED * 8, *BESIDE.values()]


def changed(rng: np.random.Generator, texts: list[str]) -> bytes:
    """Return a text with one to six changes."""
    text = texts[rng.integers(len(texts))]
    lines = text.split("\n")
    start = int(rng.integers(len(lines)))
    lines = lines[:2] + lines[start : start + int(rng.integers(1, 40))] if rng.random() < 0.5 else lines
    for _ in range(int(rng.integers(1, 7))):
        lines = _CHANGES[rng.integers(len(_CHANGES))](rng, lines, texts) or [""]
    return "\n".join(lines).encode("utf-8", "surrogatepass")


def _without_line(rng: np.random.Generator, lines: list[str], texts: list[str]) -> list[str]:
    at = int(rng.integers(len(lines)))
    return lines[:at] + lines[at + 1 :]


def _with_line_twice(rng: np.random.Generator, lines: list[str], texts: list[str]) -> list[str]:
    at, to = rng.integers(len(lines), size=2).tolist()
    return [*lines[:to], lines[at], *lines[to:]]


def _with_foreign_lines(rng: np.random.Generator, lines: list[str], texts: list[str]) -> list[str]:
    other = texts[rng.integers(len(texts))].split("\n")
    at, source = int(rng.integers(len(lines))), int(rng.integers(len(other)))
    return lines[:at] + other[source : source + int(rng.integers(1, 6))] + lines[at:]


def _with_wild_value(rng: np.random.Generator, lines: list[str], texts: list[str]) -> list[str]:
    at = int(rng.integers(len(lines)))
    tokens = list(re.finditer(r"[-+.\w#/]+", lines[at]))
    if not tokens:
        return lines
    token, wild = tokens[rng.integers(len(tokens))], WILD[rng.integers(len(WILD))]
    return [*lines[:at], lines[at][: token.start()] + wild + lines[at][token.end() :], *lines[at + 1 :]]


def _with_character(rng: np.random.Generator, lines: list[str], texts: list[str]) -> list[str]:
    at = int(rng.integers(len(lines)))
    column = int(rng.integers(len(lines[at]) + 1))
    character = chr(int(rng.choice([*range(32, 127), 0, 7, 9, 13, 0x85, 0x2028, 0xFEFF, 0xE9, 0x1F600])))
    return [*lines[:at], lines[at][:column] + character + lines[at][column + int(rng.integers(2)) :], *lines[at + 1 :]]


def _indented(rng: np.random.Generator, lines: list[str], texts: list[str]) -> list[str]:
    at = int(rng.integers(len(lines)))
    line = lines[at][2:] if rng.random() < 0.5 else "  " + lines[at]
    return [*lines[:at], line, *lines[at + 1 :]]


_CHANGES = (_without_line, _with_line_twice, _with_foreign_lines, _with_wild_value, _with_character, _indented)


def trees() -> st.SearchStrategy[dict[str, Any]]:
    """Return worlds of valid keys in random places, with random values."""
    schema = world_schema()
    known = {key for kind in [schema, *schema["$defs"].values()] for key in kind.get("properties", {})}
    keys = st.sampled_from(
        sorted({*known, "include", "variables", "repeat", "use", "times", "offset", "walss", "turn_deg"})
    )
    leaves = st.one_of(st.sampled_from(VALUES), st.floats(), st.integers(), st.text(max_size=8))
    values = st.recursive(
        leaves,
        lambda inner: st.one_of(st.lists(inner, max_size=4), st.dictionaries(keys, inner, max_size=5)),
        max_leaves=25,
    )
    items = {
        key: st.lists(st.dictionaries(_keys_of(schema, key), values, max_size=6), max_size=4) for key in _lists(schema)
    }
    return st.builds(
        lambda whole, wild: {"mjsim": 1, **whole, **wild},
        st.fixed_dictionaries({}, optional=items),
        st.dictionaries(keys, values, max_size=3),
    )


def _lists(schema: dict[str, Any]) -> list[str]:
    return [key for key, value in schema["properties"].items() if "array" in json.dumps(value)]


def _keys_of(schema: dict[str, Any], key: str) -> st.SearchStrategy[str]:
    kinds = re.findall(r"#/\$defs/(\w+)", json.dumps(schema["properties"][key]))
    return st.sampled_from(
        sorted({"repeat", *(name for kind in kinds for name in schema["$defs"][kind]["properties"])})
    )


def run_changed(trial: WorldTrial, inputs: int, seed: int) -> None:
    """Read shipped worlds that were changed."""
    rng, texts = np.random.default_rng(seed), seeds()
    for _ in range(inputs):
        trial.read(changed(rng, texts))


def run_built(trial: WorldTrial, inputs: int, seed: int) -> None:
    """Read trees that hypothesis builds."""

    @hypothesis_seed(seed)
    @settings(
        max_examples=inputs,
        deadline=None,
        database=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(trees())
    def read(tree: dict[str, Any]) -> None:
        trial.read(json.dumps(tree, ensure_ascii=False).encode("utf-8", "surrogatepass"))

    read()


def run_bytes(inputs: int, seed: int) -> int:
    """Let atheris search for inputs in a separate process, which ends with it; return the exit code."""
    with tempfile.TemporaryDirectory() as folder:
        for index, text in enumerate(seeds()):
            (Path(folder) / f"{index}.yaml").write_text(text[:4000], encoding="utf-8")
        command = [sys.executable, __file__, "--atheris", folder, f"-runs={inputs}", f"-seed={seed}", "-max_len=4096"]
        done = subprocess.run([*command, f"-timeout={20 * LIMIT:.0f}", "-verbosity=0"], check=False)
        return done.returncode


def serve_atheris(arguments: list[str]) -> None:
    """Run atheris in this process."""
    import atheris

    with atheris.instrument_imports(include=["mjsim.world", "ruamel.yaml"], enable_loader_override=False):
        import mjsim.world.read.world_reader  # noqa: F401  # already imported ones are instrumented below
    for module in [name for name in sys.modules if name.startswith("mjsim.world")]:
        for value in list(vars(sys.modules[module]).values()):
            if callable(value) and getattr(value, "__module__", None) == module and hasattr(value, "__code__"):
                atheris.instrument_func(value)
    with tempfile.TemporaryDirectory() as folder:
        trial = WorldTrial(Path(folder))
        atheris.Setup([sys.argv[0], *arguments], trial.read)
        atheris.Fuzz()


def engines(name: str) -> Iterator[str]:
    """Yield the engines of a name."""
    yield from ("changed", "built", "bytes") if name == "all" else (name,)


def main() -> int:
    """Read the requested number of inputs, shared evenly by the engines."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--inputs", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--engine", choices=("changed", "built", "bytes", "all"), default="all")
    options = parser.parse_args()
    chosen = list(engines(options.engine))
    share = -(-options.inputs // len(chosen))
    for engine in chosen:
        start = time.perf_counter()
        if engine == "bytes":
            if run_bytes(share, options.seed):
                return 1
            print(f"bytes: {share} inputs, no traceback, {time.perf_counter() - start:.0f} s")
            continue
        with tempfile.TemporaryDirectory() as folder:
            trial = WorldTrial(Path(folder))
            try:
                (run_changed if engine == "changed" else run_built)(trial, share, options.seed)
            except BaseException:
                kept = ROOT / "out" / "fuzz" / f"{engine}.yaml"
                kept.parent.mkdir(parents=True, exist_ok=True)
                kept.write_bytes(trial.last)
                print(f"the input is kept in {kept}", file=sys.stderr)
                raise
        taken = time.perf_counter() - start
        print(
            f"{engine}: {trial.count} inputs, {trial.worlds} of them worlds, {trial.laid} reformatted, no traceback,"
            f" slowest {trial.slowest:.2f} s, {taken:.0f} s"
        )
    return 0


if __name__ == "__main__":
    if sys.argv[1:2] == ["--atheris"]:
        serve_atheris(sys.argv[2:])
    sys.exit(main())
