"""Import broken logs by the thousand: each must become a recording, or be refused in one line.

python scripts/fuzz/logs.py [--inputs 1000] [--commands 0] [--seed 1] [FORMAT ...]

Takes a small log of each format, and changes numbers, words, bytes, sizes and pieces of its files, or packs them. Each
is read in the guarded child, which is used again, and so many also by `mjsim import-log`. Prints what became of them;
inputs whose reader crashed, swelled or took too long are kept in out/fuzz, and so is the first that ends otherwise,
which ends the script with exit code 1.
"""

import argparse
import bz2
import gzip
import lzma
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from log_seeds import MAKERS, Files, seed_of

from mjsim.errors import MjsimError
from mjsim.guarded import Reader
from mjsim.logs import Wishes
from mjsim.logs.importing import limits_of

KEPT = Path(__file__).resolve().parents[2] / "out" / "fuzz"
LIMIT = 120.0
"""Time for the command, on a busy machine [s]."""
MAIN = "from mjsim.cli import main; main()"
CONVERT, SENT = "mjsim.logs.kinds:convert", "mjsim.logs.importing:sent"
HARM = ("its reader crashed", "it took longer", "it needs more than", "its reader ended", "no valid answer")
"""What the guard says of a reader that it had to end."""
REUSED = 100
"""Inputs read by one child: scenes of MuJoCo in cycles wait for the collector, but count."""
NUMBER = re.compile(rb"[-+]?\d+(?:\.\d+)?")
WORDS = (
    *(b"0", b"-1", b"1e308", b"-1e308", b"nan", b"inf", b"5e-324", b"9" * 30, b"1e9", b"4294967295", b"", b"a"),
    *(b"../x", b"/etc/passwd", b"\xff\xfe", b"\x00", b"#", b'"', b"[" * 60, b"&a *a", b"\r", b",,,,", b"1.5.5"),
)
"""What stands where a number should."""
SIZES = (b"\xff" * 4, b"\x00" * 4, b"\xff\xff\xff\x7f", b"\x00\x00\x00\x80", b"\x01\x00\x00\x00", b"\x00\xca\x9a\x3b")
"""What stands where four bytes of a size may."""
PACKERS = (gzip.compress, lzma.compress, bz2.compress)


def changed(data: bytes, rng: random.Random) -> bytes:
    """Return a file with a few changes."""
    is_text = b"\x00" not in data[:200]
    for _ in range(rng.choice((1, 1, 1, 2, 3, 8))):
        at, length = rng.randrange(len(data) + 1), rng.choice((1, 1, 4, 8, 40, 400))
        if is_text and rng.random() < 0.7 and (places := [each.span() for each in NUMBER.finditer(data)]):
            start, end = rng.choice(places)
            data = data[:start] + rng.choice(WORDS) + data[end:]
            continue
        piece = rng.randrange(len(data) + 1)
        data = rng.choice(
            (
                data[:at] + bytes([rng.randrange(256)]) + data[at + 1 :],
                data[:at] + rng.choice(SIZES) + data[at + 4 :],
                data[:at] + rng.choice(SIZES) + bytes(4) + data[at + 8 :],
                data[:at] + data[at + length :],
                data[:at] + data[piece : piece + length] + data[at:],
                data[:at] + data[piece : piece + length] + data[at + length :],
                data[:at] if rng.random() < 0.3 else data[:at] + rng.choice(WORDS) + data[at:],
            )
        )
    return rng.choice(PACKERS)(data)[: rng.choice((None, None, -9))] if rng.random() < 0.03 else data


def changed_files(files: Files, rng: random.Random) -> Files:
    """Return a log in which one or two files are changed, or gone."""
    names = [rng.choice(list(files)) for _ in range(rng.choice((1, 1, 2)))]
    new = files | {name: changed(files[name], rng) for name in names}
    return {name: data for name, data in new.items() if name != names[0] or len(new) == 1 or rng.random() > 0.02}


def put(files: Files, folder: Path) -> Path:
    """Write a log into an empty folder; return what is to be imported."""
    for each in folder.iterdir():
        shutil.rmtree(each) if each.is_dir() else each.unlink()
    for name, data in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(data)
    return next((folder / name for name in files if name in ("run.log", "log.yaml", "run.bag")), folder)


def read(reader: Reader, path: Path) -> str:
    """Import a log by a guarded child, and return what became of it."""
    wishes = Wishes(seconds=0.3)
    try:
        for _ in reader.parts(SENT, CONVERT, path, wishes, "", about=path, limits=limits_of(path)):
            pass
    except MjsimError as error:
        lines = str(error).splitlines()
        assert len(lines) == 1 or path.suffix == ".yaml", lines
        assert all(line.isprintable() for line in lines), lines
        said = [harm for harm in HARM if harm in lines[0]]
        by_library = re.search(r"cannot be read: (\w+)(?:: .*)?; the file may be damaged", lines[0])
        return said[0] if said else f"refused by {by_library[1]}" if by_library else "refused"
    return "a recording"


def command(path: Path, folder: Path) -> str:
    """Import a log by the command, and return what became of it."""
    out = folder / "run.mcap"
    words = [sys.executable, "-c", MAIN, "import-log", str(path), "-o", str(out), "--overwrite", "--seconds", "0.3"]
    done = subprocess.run(words, capture_output=True, text=True, timeout=LIMIT, cwd=folder)
    assert done.returncode in (0, 2), (done.returncode, done.stderr)
    assert "Traceback" not in done.stderr, done.stderr
    return "a recording" if done.returncode == 0 else "refused"


def run(name: str, *, inputs: int, commands: int, seed: int) -> Counter[str]:
    """Try so many changed logs of a format, the first ones also by the command; return what became of them."""
    rng, files, ends = random.Random(f"{seed} {name}"), seed_of(name), Counter[str]()
    with tempfile.TemporaryDirectory() as place, tempfile.TemporaryDirectory() as out:
        folder, count = Path(place), max(inputs, commands)
        for begin in range(0, count, REUSED):
            with Reader(CONVERT, folders=[folder], scratch=True) as reader:
                assert read(reader, put(files, folder)) == "a recording", f"the log of {name} is not read"
                for number in range(begin, min(begin + REUSED, count)):
                    path = put(changed_files(files, rng), folder)
                    with kept(folder, f"{name}-{seed}-{number}"):
                        ends[end := read(reader, path)] += 1
                        if number < commands:
                            ends[f"by the command {command(path, Path(out))}"] += 1
                        assert end not in HARM, end
    return ends


@contextmanager
def kept(folder: Path, name: str) -> Iterator[None]:
    """Keep a log if the block fails; what the guard had to end is only said."""
    try:
        yield
    except BaseException as error:
        shutil.copytree(folder, KEPT / name, dirs_exist_ok=True)
        if not (isinstance(error, AssertionError) and str(error) in HARM):
            raise


def main(names: Sequence[str] = tuple(MAKERS)) -> None:
    """Try as many inputs of each format as the arguments say."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("formats", nargs="*", choices=[[], *names], metavar="FORMAT", help=", ".join(names))
    parser.add_argument("--inputs", type=int, default=1000)
    parser.add_argument("--commands", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    for name in given.formats or names:
        start = time.perf_counter()
        ends = run(name, inputs=given.inputs, commands=given.commands, seed=given.seed)
        print(f"{name}, seed {given.seed}: {dict(ends.most_common())}, {time.perf_counter() - start:.0f} s", flush=True)


if __name__ == "__main__":
    main()
