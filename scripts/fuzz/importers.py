"""Read broken files of strangers by the thousand in the guarded reader: each must come in, or be refused in one line.

python scripts/fuzz/importers.py [--inputs 100000] [--commands 0] [--seed 1] [--only svg]

Takes small files that come in, and changes bytes, numbers and pieces, in PNG files below their checksums. Each is read
in the guarded child, which is used again, and so many also by `mjsim new` or `mjsim check`, whose memory and time are
watched. The first input that ends otherwise than in a world or in printable lines is left in out/fuzz and ends the
script; so are those that end their child (a signal, or too much time or memory), which are counted.
"""

import argparse
import os
import random
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import time
import zlib
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from scipy.io import savemat

from mjsim.errors import MjsimError
from mjsim.exchange import Reading, RobotOptions, bring_file, bring_robot
from mjsim.guarded import one_reader
from mjsim.world import Source, parse_world

ROOT = Path(__file__).resolve().parents[2]
DATA = ROOT / "tests" / "data"
SEEDS: dict[str, Path | None] = {
    "svg": DATA / "plans/flat.svg",
    "dxf": DATA / "plans/house.dxf",
    "yaml": DATA / "maps/house.yaml",
    "png": DATA / "maps/house.png",
    "mat": None,
    "urdf": DATA / "robots/turtlebot3_description/urdf/turtlebot3_burger.urdf",
    "jpg": ROOT / "assets/posters/lion.jpg",
    "poster": DATA / "maps/house.png",
}
"""Importer -> a file that comes in; a landmark map is made. The last two hang in a world."""
SHOWN = {"jpg": "jpg", "poster": "png"}
"""Kind of a picture in a world -> its suffix."""
SIGNATURE = b"\x89PNG\r\n\x1a\n"
COMMAND = "from mjsim.cli import main; main()"
LONGEST, LARGEST = 60.0, 1 << 30
"""Time of the command on a busy machine [s], and its memory [bytes]."""
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


def changed_png(data: bytes, rng: random.Random) -> bytes:
    """Return a PNG file in which a chunk or the pixels are changed, with right checksums."""
    chunks = list(chunks_of(data))
    at = rng.randrange(len(chunks))
    kind, content = chunks[at]
    if kind == b"IDAT" and rng.random() < 0.8:
        pixels = zlib.decompress(b"".join(part for name, part in chunks if name == b"IDAT"))
        chunks = [each for each in chunks if each[0] != b"IDAT"]
        chunks.insert(-1, (b"IDAT", zlib.compress(changed(pixels, rng), 1)))
    else:
        chunks[at] = kind, changed(content, rng)
    parts = (
        struct.pack(">I", len(part)) + name + part + struct.pack(">I", zlib.crc32(name + part)) for name, part in chunks
    )
    return SIGNATURE + b"".join(parts)


def chunks_of(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Yield kind and content of the chunks of a whole PNG file."""
    place = len(SIGNATURE)
    while place < len(data):
        length, kind = struct.unpack(">I4s", data[place : place + 8])
        yield kind, data[place + 8 : place + 8 + length]
        place += 12 + length


def whole_of(kind: str) -> bytes:
    """Return the file that is changed."""
    path = SEEDS[kind]
    if path is not None:
        return path.read_bytes()
    with tempfile.TemporaryFile() as file:
        savemat(file, {"lm": [[1.0, 4.0, 7.0], [2.0, 5.0, 8.0]], "wp": [[1.0, 3.0], [1.0, 3.0]]})
        file.seek(0)
        return file.read()


def input_of(kind: str, whole: bytes, rng: random.Random) -> bytes:
    """Return a changed file of a kind."""
    return changed_png(whole, rng) if whole.startswith(SIGNATURE) and rng.random() < 0.8 else changed(whole, rng)


def world_of(name: str) -> str:
    """Return a world in which a picture hangs."""
    return f"mjsim: 1\nbeacons: [{{name: a, image: {name}, at: [1, 2], width: 1}}]\n"


def trial(kind: str, path: Path) -> str:
    """Bring a file in, and return what became of it."""
    try:
        if kind == "urdf":
            bring_robot(path, name="r", options=RobotOptions(), packages={}, arguments={})
        elif kind in SHOWN:
            parse_world(world_of(path.name), source=Source(folder=path.parent))
        else:
            bring_file(path, robot=None, reading=Reading(scale=None if kind in ("yaml", "dxf") else 0.05))
    except MjsimError as error:
        lines = str(error).splitlines()
        assert all(line.isprintable() for line in lines)
        return "ended its child" if any(words in lines[0] for words in ENDED) else "refused"
    return "came in"


def run(kind: str, count: int, *, seed: int, folder: Path) -> Counter[str]:
    """Try so many inputs of one importer in one child; each lies in a folder while it is tried."""
    rng, whole, ends = random.Random(seed), whole_of(kind), Counter[str]()
    path = folder / f"last.{SHOWN.get(kind, kind)}"
    with one_reader("mjsim.exchange.inside:world_file", folders=[folder]):
        for _ in range(count):
            path.write_bytes(input_of(kind, whole, rng))
            end = trial(kind, path)
            ends[end] += 1
            if end == "ended its child":
                path.rename(folder / f"ended-{seed}-{ends[end]}{path.suffix}")
    path.unlink(missing_ok=True)
    return ends


def run_commands(kind: str, count: int, *, seed: int, folder: Path) -> Counter[str]:
    """Try so many inputs of one importer with the whole command."""
    rng, whole, ends = random.Random(-seed), whole_of(kind), Counter[str]()
    path, world = folder / f"command.{SHOWN.get(kind, kind)}", folder / "command-world.yaml"
    words = ["new", "--robot-from" if kind == "urdf" else "--from", str(path), "--overwrite", "-o", str(world)]
    words += [] if kind == "urdf" else ["--no-robot"]
    words += ["--scale", "0.05"] if kind in ("svg", "png") else []
    for _ in range(count):
        path.write_bytes(input_of(kind, whole, rng))
        if kind in SHOWN:
            world.write_text(world_of(path.name))
            words = ["check", str(world)]
        ends[command(words)] += 1
    path.unlink(missing_ok=True)
    return ends


def command(words: list[str]) -> str:
    """Run mjsim with the input that lies in the folder, and return what became of it."""
    with tempfile.TemporaryFile() as said:
        started = subprocess.Popen([sys.executable, "-c", COMMAND, *words], stdout=said, stderr=said)
        begun = time.monotonic()
        while not (done := os.wait4(started.pid, os.WNOHANG))[0]:
            if time.monotonic() > begun + LONGEST:
                started.kill()
                raise TimeoutError(f"{words} took longer than {LONGEST} s")
            time.sleep(0.02)
        started.returncode = code = os.waitstatus_to_exitcode(done[1])
        said.seek(0)
        text = said.read().decode()
    assert code in (0, 2), (words, code, text)
    assert "Traceback" not in text, text
    assert done[2].ru_maxrss << 10 < LARGEST, (words, done[2].ru_maxrss)
    return "came in" if code == 0 else "refused"


def main() -> None:
    """Try as many inputs of each importer as the arguments say."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--inputs", type=int, default=100_000)
    parser.add_argument("--commands", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", choices=SEEDS)
    arguments = parser.parse_args()
    folder = ROOT / "out" / "fuzz"
    folder.mkdir(parents=True, exist_ok=True)
    shutil.copy(DATA / "maps/house.png", folder)  # the map's YAML file names it
    for kind in [arguments.only] if arguments.only else SEEDS:
        for each, count in ((run, arguments.inputs), (run_commands, arguments.commands)):
            start = time.monotonic()
            ends = each(kind, count, seed=arguments.seed, folder=folder)
            print(f"{kind}: {ends.total()} inputs: {dict(ends)}, {time.monotonic() - start:.0f} s", file=sys.stderr)


if __name__ == "__main__":
    main()
