"""Read thousands of hostile recordings: each must be read, or refused in one line.

What is read is also looked at: statistics, tables, the studio's review, observations, an export of some kind, now and
then plots, a replay and a film.

python scripts/fuzz/recordings.py [--inputs 100000] [--seed 1] [--engine records|bytes|messages|all]

'records' takes small recordings apart and changes records, chunks, numbers and names in them, checksums and all;
'bytes' changes, cuts and doubles bytes of the file; 'messages' lets atheris follow the coverage of the reader over the
content of single messages. Another seed gives other inputs. The first input that ends in a traceback or a warning, or
takes too much time or memory, is kept in out/fuzz and ends the script with exit code 1.
"""

import argparse
import copy
import subprocess
import sys
import tempfile
import time
from itertools import islice
from pathlib import Path

import numpy as np
from recording_changes import changed_bytes, changed_records, one_of, put_together, taken_apart
from recording_trial import LIMIT, MEMORY, RecordingTrial, seeds

from mjsim.bench.large import peak_memory

KEPT = Path(__file__).resolve().parents[2] / "out" / "fuzz"
"""Where the first bad input is kept."""


def run_records(trial: RecordingTrial, inputs: int, seed: int, data: list[bytes]) -> None:
    """Read recordings of changed records."""
    rng = np.random.default_rng(seed)
    for _ in range(inputs):
        trial.read(changed_records(rng, one_of(rng, data)))


def run_bytes(trial: RecordingTrial, inputs: int, seed: int, data: list[bytes]) -> None:
    """Read recordings of changed bytes."""
    rng = np.random.default_rng(seed)
    for _ in range(inputs):
        trial.read(changed_bytes(rng, one_of(rng, data)))


def run_messages(inputs: int, seed: int) -> int:
    """Let atheris search for messages in a separate process, which ends with it; return the exit code."""
    KEPT.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        (data, _) = seeds(Path(folder))
        corpus = Path(folder) / "corpus"
        corpus.mkdir()
        for index, message in enumerate(islice(taken_apart(data).messages, 60)):
            (corpus / str(index)).write_bytes(bytes([index]) + message.data)
        command = [sys.executable, __file__, "--atheris", str(corpus), f"-runs={inputs}", f"-seed={seed}"]
        # The trial itself looks at the processor's time; this is the clock's, on however loaded a machine.
        limits = ["-max_len=4096", f"-timeout={20 * LIMIT:.0f}", f"-rss_limit_mb={MEMORY}"]
        return subprocess.run([*command, *limits, f"-artifact_prefix={KEPT}/", "-verbosity=0"], check=False).returncode


def serve_atheris(arguments: list[str]) -> None:
    """Run atheris in this process."""
    import atheris

    for module in [name for name in sys.modules if name.startswith(("mjsim.record", "mjsim.report"))]:
        for value in list(vars(sys.modules[module]).values()):
            if callable(value) and getattr(value, "__module__", None) == module and hasattr(value, "__code__"):
                atheris.instrument_func(value)
    with tempfile.TemporaryDirectory() as folder:
        parts, rng = taken_apart(seeds(Path(folder))[0]), np.random.default_rng(0)
        trial = RecordingTrial(Path(folder) / "trial")
        trial.file.parent.mkdir()

        def read(data: bytes) -> None:
            if data:
                changed = copy.copy(parts)
                at = data[0] % len(parts.messages)
                message = copy.copy(parts.messages[at])
                message.data = data[1:]
                changed.messages = [*parts.messages[:at], message, *parts.messages[at + 1 :]]
                trial.read(put_together(changed, rng))

        atheris.Setup([sys.argv[0], *arguments], read)
        atheris.Fuzz()


def run_engine(engine: str, inputs: int, seed: int) -> None:
    """Read inputs of 'records' or 'bytes', and print how that went; the first bad one is kept."""
    start = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        data, place = seeds(Path(folder)), Path(folder) / "trial"
        place.mkdir()
        trial = RecordingTrial(place)
        try:
            (run_records if engine == "records" else run_bytes)(trial, inputs, seed, data)
        except BaseException:
            KEPT.mkdir(parents=True, exist_ok=True)
            (KEPT / f"{engine}.mcap").write_bytes(trial.last)
            print(f"input {trial.count} is kept in {KEPT / engine}.mcap", file=sys.stderr)
            raise
    print(
        f"{engine}: seed {seed}, {trial.count} inputs, {trial.read_well} of them recordings, no traceback, slowest"
        f" {trial.slowest:.2f} s, peak memory {peak_memory():.0f} MB, {time.perf_counter() - start:.0f} s"
    )


def main() -> int:
    """Read the requested number of inputs, shared evenly by the engines."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--inputs", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--engine", choices=("records", "bytes", "messages", "all"), default="all")
    options = parser.parse_args()
    chosen = ("records", "bytes", "messages") if options.engine == "all" else (options.engine,)
    share = -(-options.inputs // len(chosen))
    for engine in chosen:
        if engine != "messages":
            run_engine(engine, share, options.seed)
            continue
        start = time.perf_counter()
        if run_messages(share, options.seed):
            return 1
        print(f"messages: seed {options.seed}, {share} inputs, no traceback, {time.perf_counter() - start:.0f} s")
    return 0


if __name__ == "__main__":
    if sys.argv[1:2] == ["--atheris"]:
        serve_atheris(sys.argv[2:])
    sys.exit(main())
