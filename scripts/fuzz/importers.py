"""Read thousands of broken files in the guarded reader: each must be imported, or refused in one line.

python scripts/fuzz/importers.py [--inputs 1000] [--commands 0] [--seed 1] [IMPORTER ...]

Takes small valid files, changes bytes, numbers, values and pieces, and reads them in a guarded child process, which is
reused; other inputs go through the whole command, each in a copy of a process that has imported mjsim. Prints a table
with a row for each importer. Inputs that give neither a value nor printable lines, that end their child process, or
that take too much time or memory are kept in out/fuzz; a traceback or a hang makes the exit code 1.
"""

import argparse
import contextlib
import os
import re
import shutil
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from random import Random

os.environ |= {"OMP_NUM_THREADS": "1", "XDG_CACHE_HOME": "/dev/null/none"}  # What was read is read again.

from changes import Files, changed_files
from log_seeds import MAKERS, seed_of
from seeds import DRIVEN, ROOT, SEEDS
from xacro_seeds import files_of

from mjsim.cli import main as mjsim
from mjsim.compile import check_models, compile_world
from mjsim.errors import MjsimError
from mjsim.exchange import Reading, RobotOptions, bring_file, bring_robot
from mjsim.guarded import Reader, one_reader
from mjsim.logs import Wishes
from mjsim.logs.importing import limits_of
from mjsim.world import Source, parse_world

KEPT = ROOT / "out" / "fuzz"
SECONDS, LONGEST, MEGABYTES = 20.0, 600.0, 1000.0
"""Processor time of a command [s], its time on a busy machine [s], and the memory of all its processes [MB]."""
REUSED = 1000
"""Inputs read by one child."""
ENDS = ("accepted", "refused", "ended by limit", "signals", "tracebacks")
CONVERT, SENT = "mjsim.logs.log_kinds:convert", "mjsim.logs.importing:sent"
LIMITS, SIGNALS = (
    ("it took longer", "it needs more than"),
    ("its reader crashed", "its reader ended", "no valid answer"),
)
"""Parts of messages about files that ended their child."""


@dataclass(frozen=True, slots=True)
class Importer:
    """Reads files of one kind."""

    seeds: Sequence[Files]
    read: Callable[[Reader, Path], object]
    words: Callable[[Path, Path], Sequence[str]]
    """Words of the command, from the file and a folder for what it writes."""
    function: str
    """A function of the child."""
    fresh: Callable[[Random], Files] | None = None
    """Generates random files, instead of seeds."""

    def inputs(self, rng: Random) -> Iterator[Files]:
        """Yield broken files."""
        while True:
            files = rng.choice(self.seeds) if self.fresh is None else self.fresh(rng)
            yield changed_files(files, rng) if self.fresh is None or rng.random() < 0.3 else files


def _drawing(scale: float | None) -> Callable[[Reader, Path], object]:
    return lambda _, path: bring_file(path, robot=None, reading=Reading(scale=scale))


def _new(*options: str) -> Callable[[Path, Path], Sequence[str]]:
    return lambda path, out: ["new", "--from", str(path), "--no-robot", "-o", str(out / "w.yaml"), *options]


def _robot(_: Reader, path: Path) -> object:
    return bring_robot(path, name="r", options=RobotOptions(), packages={}, arguments={})


def _text(path: Path) -> str:
    """Return a world with a picture on a wall, or with an object."""
    if path.stem == "picture":
        return f"mjsim: 1\nbeacons: [{{name: a, image: {path.name}, at: [1, 2], width: 1}}]\n"
    return f"mjsim: 1\nobstacles: [{{name: a, model: {path.name}, at: [1, 2], movable: true}}]\n"


def _stands(_: Reader, path: Path) -> object:
    world = parse_world(_text(path), source=Source(folder=path.parent))
    check_models(world)
    return compile_world(world).compile()


def _check(path: Path, out: Path) -> Sequence[str]:
    (path.parent / "world.yaml").write_text(_text(path))
    return ["check", str(path.parent / "world.yaml")]


def _log(reader: Reader, path: Path) -> object:
    return list(reader.parts(SENT, CONVERT, path, Wishes(seconds=0.3), "", about=path, limits=limits_of(path)))


def _xacro(rng: Random) -> Files:
    files, (robot,) = files_of(rng), SEEDS["robot in URDF"]
    head, _, rest = files["robot.xacro"].partition(b"<group>")
    text = head + DRIVEN.encode() + b"<gazebo>" + rest.replace(b"</group>", b"</gazebo>")
    return {"robot.xacro": text} | {name: data for name, data in (robot | files).items() if "robot." not in name}


def importers() -> Iterator[tuple[str, Importer]]:
    """Yield the importers by name."""
    world, robot = "mjsim.exchange.inside:world_file", "mjsim.exchange.inside:robot"
    for name, seeds in SEEDS.items():
        scale = {"svg": 0.05, "image of a map": 0.05}.get(name)
        options = () if scale is None else ("--scale", str(scale))
        if name.startswith("robot"):
            yield name, Importer(seeds, _robot, _brought, robot)
        elif name in ("svg", "dxf", "map", "image of a map", "mat") or name.startswith("scene"):
            yield name, Importer(seeds, _drawing(scale), _new(*options), world)
        else:
            yield name, Importer(seeds, _stands, _check, "mjsim.models.trials:model")
    yield "robot in xacro", Importer(SEEDS["robot in URDF"], _robot, _brought, robot, _xacro)
    for name in MAKERS:
        yield name, Importer([seed_of(name)], _log, _imported, CONVERT)


def _brought(path: Path, out: Path) -> Sequence[str]:
    return ["new", "--robot-from", str(path), "-o", str(out / "r.yaml")]


def _imported(path: Path, out: Path) -> Sequence[str]:
    return ["import-log", str(path), "-o", str(out / "run.mcap"), "--seconds", "0.3"]


def put(files: Files, folder: Path) -> None:
    """Write files into an emptied folder."""
    for each in folder.iterdir():
        shutil.rmtree(each) if each.is_dir() else each.unlink()
    for name, data in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(data)


def placed(importer: Importer, files: Files, folder: Path) -> Path:
    """Write files into an emptied folder; return what is to be read."""
    put(files, folder)
    if importer.function != CONVERT:
        return folder / next(iter(files))
    return next((folder / name for name in ("run.log", "log.yaml", "run.bag") if name in files), folder)


def end_of(text: str) -> str:
    """Return the outcome of a file that is refused."""
    if not all(line.isprintable() for line in text.splitlines()):
        return "tracebacks"
    kinds = (("ended by limit", LIMITS), ("signals", SIGNALS))
    return next((end for end, words in kinds if any(word in text for word in words)), "refused")


def read(importer: Importer, reader: Reader, path: Path) -> str:
    """Read a file in the guarded child; return the outcome."""
    try:
        importer.read(reader, path)
    except MjsimError as error:
        return end_of(str(error))
    except Exception:
        traceback.print_exc()
        return "tracebacks"
    return "accepted"


def tried(importer: Importer, count: int, rng: Random, folder: Path) -> Iterator[tuple[str, Files, float]]:
    """Yield the outcome of each input, the input, and the peak memory of this process and its child [MB]."""
    inputs = importer.inputs(rng)
    for begin in range(0, count, REUSED):
        log = Reader(CONVERT, folders=[folder], scratch=True) if importer.function == CONVERT else None
        with log or one_reader(importer.function, folders=[folder]) as reader:
            assert read(importer, reader, placed(importer, importer.seeds[0], folder)) == "accepted"
            for _, files in zip(range(begin, min(begin + REUSED, count)), inputs, strict=False):
                yield read(importer, reader, placed(importer, files, folder)), files, memory(os.getpid())


def commanded(importer: Importer, count: int, rng: Random, folder: Path) -> Iterator[tuple[str, Files, float]]:
    """Yield the same for inputs that the whole command reads."""
    inputs = importer.inputs(rng)
    for _, files in zip(range(count), inputs, strict=False):
        path = placed(importer, files, folder)
        with tempfile.TemporaryDirectory() as out:
            end, megabytes = command(importer.words(path, Path(out)), Path(out) / "said")
        yield end, files, megabytes


def command(words: Sequence[str], said: Path) -> tuple[str, float]:
    """Run mjsim in a copy of this process; return the outcome, and the peak memory [MB]."""
    process = os.fork()
    if process == 0:
        serve(words, said)
    begun, megabytes = time.monotonic(), 0.0
    while not (done := os.wait4(process, os.WNOHANG))[0]:
        megabytes = max(megabytes, memory(process))
        if time.monotonic() > begun + LONGEST:
            os.killpg(process, 9)
        time.sleep(0.02)
    text, code = said.read_text(errors="surrogateescape"), os.waitstatus_to_exitcode(done[1])
    if "Traceback" in text or code not in (0, 2):
        sys.stderr.write(f"{words}: {code}\n{text}\n")
        return "tracebacks", megabytes
    is_over = done[2].ru_utime + done[2].ru_stime > SECONDS + 5.0 or megabytes > MEGABYTES
    return "tracebacks" if is_over else "accepted" if code == 0 else end_of(text), megabytes


def serve(words: Sequence[str], said: Path) -> None:
    """Run mjsim as requested, in a process of its own, until it ends."""
    code = 1
    try:
        os.setsid()
        out = os.open(said, os.O_WRONLY | os.O_CREAT)
        os.dup2(out, 1)
        os.dup2(out, 2)
        mjsim(words)
    except SystemExit as end:
        code = int(end.code or 0)
    except BaseException:
        traceback.print_exc()
    with contextlib.suppress(OSError, ValueError):
        sys.stdout.flush()
        sys.stderr.flush()
    os._exit(code)


def memory(process: int) -> float:
    """Return the sum of the peak memory of a process and its children [MB]; shared memory counts for each."""
    found = 0.0
    with contextlib.suppress(OSError):
        status = Path(f"/proc/{process}/status").read_text()
        found += int(re.search(r"VmHWM:\s+(\d+)", status)[1]) / 1e3 if "VmHWM" in status else 0.0
        for task in Path(f"/proc/{process}/task").iterdir():
            found += sum(memory(int(child)) for child in (task / "children").read_text().split())
    return found


def row(name: str, importer: Importer, trials: Iterator[tuple[str, Files, float]], seed: int) -> tuple[str, bool]:
    """Return the row of the table about some trials, and whether all ended well."""
    ends, most, begun = Counter[str](), 0.0, time.monotonic()
    for end, files, megabytes in trials:
        ends[end] += 1
        most = max(most, megabytes)
        if end not in ("accepted", "refused"):
            place = KEPT / f"{name}-{end}-{seed}-{ends.total()}".replace(" ", "-")
            place.mkdir(parents=True, exist_ok=True)
            put(files, place)
    cells = [name, ends.total(), round(time.monotonic() - begun), *(ends[each] for each in ENDS), round(most)]
    return f"| {' | '.join(map(str, cells))} |", not ends["tracebacks"]


def main() -> int:
    """Try as many inputs of each importer as the arguments say; return the exit code."""
    known = dict(importers())
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("importers", nargs="*", choices=[[], *known], metavar="IMPORTER", help=", ".join(known))
    parser.add_argument("--inputs", type=int, default=1000)
    parser.add_argument("--commands", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    good = True
    print(f"| importer | inputs | s | {' | '.join(ENDS)} | peak MB |")
    for name in given.importers or known:
        for label, trials, count in ((name, tried, given.inputs), (f"{name}, command", commanded, given.commands)):
            with tempfile.TemporaryDirectory() as folder:
                rng = Random(f"{given.seed} {label}")
                if count:
                    line, fine = row(label, known[name], trials(known[name], count, rng, Path(folder)), given.seed)
                    good &= fine
                    print(line, flush=True)
    return not good


if __name__ == "__main__":
    sys.exit(main())
