"""Sweep a world with one process and with several, and print how many times as fast the several were.

    python scripts/measure/sweep.py [WORLD] [--seeds 0:8] [--seconds 30] [--workers 2]

The project asks that two processes are at least 1.8 times as fast as one. Measure on a machine with nothing else to do.
The sweep that the project shows, 50 seeds of the gallery for 60 s each with its camera on two cores, is

    mjsim sweep worlds/gallery.yaml --seeds 0:50 --seconds 60 --workers 2 -o out/gallery-sweep
"""

import argparse
import csv
import tempfile
import time
from pathlib import Path

import mjsim
from mjsim.sweep import parse_seeds

GALLERY = Path(__file__).resolve().parents[2] / "worlds" / "gallery.yaml"


def timed(world: Path, folder: Path, *, seeds: tuple[int, ...], seconds: float, workers: int) -> tuple[float, float]:
    """Sweep, and return how long it took, and how long all its runs took by themselves [s]."""
    began = time.perf_counter()
    mjsim.sweep(world, seeds=seeds, seconds=seconds, folder=folder, workers=workers)
    took = time.perf_counter() - began
    with (folder / "clock.csv").open() as file:
        return took, sum(float(row["total_seconds"]) for row in csv.DictReader(file))


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="How sweeps scale with processes.")
    parser.add_argument("world", type=Path, nargs="?", default=GALLERY)
    parser.add_argument("--seeds", type=parse_seeds, default=(*range(8),), help="such as 0:8")
    parser.add_argument("--seconds", type=float, default=30.0, help="simulated, of each run")
    parser.add_argument("--workers", type=int, default=2)
    options = parser.parse_args()
    print(f"{'processes':>10}{'took s':>10}{'all runs s':>12}{'runs a minute':>15}{'times one':>11}")
    tables, first = [], None
    with tempfile.TemporaryDirectory() as place:
        for workers in (1, options.workers):
            folder = Path(place) / str(workers)
            took, runs = timed(options.world, folder, seeds=options.seeds, seconds=options.seconds, workers=workers)
            first = took if first is None else first
            tables.append((folder / "table.parquet").read_bytes())
            rate = 60 * len(options.seeds) / took
            print(f"{workers:>10}{took:>10.1f}{runs:>12.1f}{rate:>15.1f}{first / took:>11.2f}", flush=True)
    print(f"the tables are {'the same bytes' if tables[0] == tables[1] else 'NOT the same'}")


if __name__ == "__main__":
    main()
