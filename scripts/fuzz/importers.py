"""Read broken files of strangers by the thousand in the guarded reader: each must come in, or be refused in one line.

python scripts/fuzz/importers.py [--inputs 100000] [--seed 1] [--only svg]

Takes small files that come in, and changes bytes, numbers and pieces. The first input that ends otherwise than in a
world or in printable lines is left in out/fuzz and ends the script; so are those that end their child (a signal, or too
much time or memory), which are counted.
"""

import argparse
import random
import re
import sys
import time
from collections import Counter
from pathlib import Path

from mjsim.errors import MjsimError
from mjsim.exchange import Reading, RobotOptions, bring_file, bring_robot
from mjsim.guarded import one_reader

ROOT = Path(__file__).resolve().parents[2]
DATA = ROOT / "tests" / "data"
SEEDS = {
    "svg": DATA / "plans/flat.svg",
    "dxf": DATA / "plans/house.dxf",
    "yaml": DATA / "maps/house.yaml",
    "png": DATA / "maps/house.png",
    "urdf": DATA / "robots/turtlebot3_description/urdf/turtlebot3_burger.urdf",
}
"""Importer -> a file that comes in."""
WILD = (b"", b"0", b"-1", b"nan", b"inf", b"1e9", b"1e308", b"-1e-308", b"9" * 30, b"\xff", b"../up", b"/dev/zero")
ENDED = ("crashed", "took longer", "needs more", "ended with", "no valid answer")
"""Words of lines about files that ended their child."""


def changed(data: bytes, rng: random.Random) -> bytes:
    """Return a file with a few changes."""
    for _ in range(rng.choice((1, 1, 2, 4))):
        at, size = rng.randrange(len(data) + 1), rng.randrange(40)
        numbers = [match.span() for match in re.finditer(rb"-?\d+\.?\d*", data[at : at + 2000])] or [(0, 0)]
        start, end = (at + place for place in rng.choice(numbers))
        data = rng.choice(
            (
                data[:start] + rng.choice(WILD) + data[end:],
                data[:start] + rng.choice(WILD) + data[end:],
                data[:at] + bytes([rng.randrange(256)]) + data[at + 1 :],
                data[:at] + data[at + size :],
                data[:at] + data[start : start + size] + data[at:],
            )
        )
    return data


def trial(kind: str, path: Path) -> str:
    """Bring a file in, and return what became of it."""
    try:
        if kind == "urdf":
            bring_robot(path, name="r", options=RobotOptions(drive="hover"), packages={}, arguments={})
        else:
            bring_file(path, robot=None, reading=Reading(scale=None if kind in ("yaml", "dxf") else 0.05))
    except MjsimError as error:
        lines = str(error).splitlines()
        assert all(line.isprintable() for line in lines)
        return "ended its child" if any(words in lines[0] for words in ENDED) else "refused"
    return "came in"


def run(kind: str, count: int, *, seed: int, folder: Path) -> Counter[str]:
    """Try so many inputs of one importer in one child; each lies in a folder while it is tried."""
    rng, whole, ends = random.Random(seed), SEEDS[kind].read_bytes(), Counter[str]()
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"last.{kind}"
    with one_reader("mjsim.exchange.inside:world_file", folders=[folder]):
        for _ in range(count):
            path.write_bytes(changed(whole, rng))
            end = trial(kind, path)
            ends[end] += 1
            if end == "ended its child":
                path.rename(folder / f"ended-{seed}-{ends[end]}.{kind}")
    path.unlink(missing_ok=True)
    return ends


def main() -> None:
    """Try as many inputs of each importer as the arguments say."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--inputs", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", choices=SEEDS)
    arguments = parser.parse_args()
    for kind in [arguments.only] if arguments.only else SEEDS:
        start = time.monotonic()
        ends = run(kind, arguments.inputs, seed=arguments.seed, folder=ROOT / "out" / "fuzz")
        print(f"{kind}: {ends.total()} inputs: {dict(ends)}, {time.monotonic() - start:.0f} s", file=sys.stderr)


if __name__ == "__main__":
    main()
