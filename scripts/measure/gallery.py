"""Run the gallery with many seeds and print how well it went: one row a seed, then what the project asks for.

    python scripts/measure/gallery.py [--seeds 20] [--first 1] [--seconds S] [--workers 2]
        [--world FILE] [--set KEY=VALUE] [-o DIR]

All noise is on: wheels slip on the floor and err, the drive does not do what it is told, and so do the pixels of the
camera. The project asks for a NEES, averaged over the seeds, below 5 at 90 % of the ticks, and for a mean error on the
last lap of at most a quarter of that of odometry.
"""

import argparse
import multiprocessing
import os
from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from itertools import repeat
from pathlib import Path

import numpy as np

Array = np.ndarray[tuple[int, ...], np.dtype[np.float64]]
Row = dict[str, float]
GALLERY = Path(__file__).resolve().parents[2] / "worlds" / "gallery.yaml"
ROBOT = "scout"
NOISY = "robots.scout.sensors.0.noise=2"
"""The one noise that the world itself leaves out: that of the camera's pixels, of 255."""
NEAR = 4.0
"""A poster that the robot passes within this distance must be in the map [m]."""
COLUMNS = {
    "seed": "4d",
    "error_m": "9.4f",
    "max_m": "8.4f",
    "odometry_m": "10.3f",
    "last_lap_m": "10.4f",
    "last_odometry_m": "15.3f",
    "heading_deg": "11.3f",
    "nees": "6.2f",
    "mapped": "6d",
    "missing": "7d",
    "false": "5d",
    "worst_poster_m": "14.4f",
    "bumps": "5d",
    "x_realtime": "10.2f",
}


def kept_or_run(
    seed: int, world_file: Path, seconds: float | None, settings: Sequence[str], folder: Path
) -> tuple[Row, Array]:
    """Return the row of one seed and its NEES, from the file of a sweep that was interrupted if it is there."""
    file = folder / f"{seed}.npz"
    if file.exists():
        with np.load(file) as kept:
            return dict(zip(COLUMNS, kept["row"].tolist(), strict=True)), kept["nees"]
    row, nees = run_seed(seed, world_file, seconds, settings)
    folder.mkdir(parents=True, exist_ok=True)
    np.savez(file, row=[row[name] for name in COLUMNS], nees=nees)
    return row, nees


def run_seed(seed: int, world_file: Path, seconds: float | None, settings: Sequence[str]) -> tuple[Row, Array]:
    """Return the row of one seed, and the NEES at each tick."""
    import mjsim
    from mjsim.geometry import align_rigid
    from mjsim.report.metrics import normalised_errors, position_errors
    from mjsim.world import with_settings

    world = with_settings(mjsim.load_world(world_file), settings)
    with mjsim.Simulation(world, seed=seed) as sim:
        recording = mjsim.run(sim, seconds=seconds)
    figures = mjsim.statistics(recording)
    own, track = figures[ROBOT], recording.robots[ROBOT]
    last = last_lap(track.truth, laps=world.model_dump()["run"]["drivers"][ROBOT]["navigator"].get("laps", 1))
    hung = {beacon.name: np.array(beacon.at) for beacon in world.beacons}
    mapped = {
        name: place
        for name, place in zip(track.landmarks.names, track.landmarks.mean[-1], strict=True)
        if np.isfinite(place).all()
    }
    passed = {n for n, at in hung.items() if np.hypot(*(track.truth[:, :2] - at).T).min() < NEAR}
    worst = np.inf
    known = [name for name in mapped if name in hung]
    if len(known) > 1:
        placed, true = np.array([mapped[n] for n in known]), np.array([hung[str(n)] for n in known])
        worst = float(np.hypot(*(align_rigid(placed, true).transform(placed) - true).T).max())
    row = {
        "seed": seed,
        "error_m": own["position_error_m"]["mean"],
        "max_m": own["position_error_m"]["max"],
        "odometry_m": own["odometry_error_m"]["mean"],
        "last_lap_m": position_errors(track.truth, track.estimate)[last].mean(),
        "last_odometry_m": position_errors(track.truth, track.odometry)[last].mean(),
        "heading_deg": own["heading_error_deg"]["mean"],
        "nees": own["nees"]["mean"],
        "mapped": len(mapped),
        "missing": len(passed.difference(mapped)),
        "false": len(mapped) - len(known),
        "worst_poster_m": worst,
        "bumps": own["bumps"],
        "x_realtime": figures["run"]["real_time_factor"],
    }
    return row, normalised_errors(track.truth, track.estimate, track.covariance)


def last_lap(truth: Array, *, laps: int) -> slice:
    """Return the ticks of the last lap: the last of as many equal parts of the way, truth having shape (N, 3)."""
    way = np.cumsum(np.hypot(*np.diff(truth[:, :2], axis=0).T))
    return slice(int(np.searchsorted(way, way[-1] * (1 - 1 / laps))), None)


def print_table(runs: Iterable[tuple[Row, Array]]) -> tuple[list[Row], Array]:
    """Print rows as they come; return them all, and the NEES of each run, shape (runs, N)."""
    rows, nees = [], []
    print("  ".join(f"{name:>{form.split('.')[0].rstrip('df')}}" for name, form in COLUMNS.items()))
    for row, own in runs:
        print("  ".join(f"{row[name]:{form.replace('d', '.0f')}}" for name, form in COLUMNS.items()), flush=True)
        rows.append(row)
        nees.append(own)
    return rows, np.array(nees)


def main() -> None:
    """Run all seeds on a few processes."""
    parser = argparse.ArgumentParser(description="Run the gallery with many seeds.")
    parser.add_argument("--seeds", type=int, default=20, help="how many")
    parser.add_argument("--first", type=int, default=1, help="the first one")
    parser.add_argument("--seconds", type=float, help="simulated; as the world says unless given")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--world", type=Path, default=GALLERY)
    parser.add_argument("--set", action="append", metavar="KEY=VALUE", help=f"in place of {NOISY}")
    parser.add_argument(
        "-o", "--output", type=Path, default=Path("out/sweep_gallery"), help="a file a seed; go on there"
    )
    options = parser.parse_args()
    os.environ |= {"OMP_NUM_THREADS": "1", "LP_NUM_THREADS": "1"}  # one core a worker
    seeds = range(options.first, options.first + options.seeds)
    with ProcessPoolExecutor(options.workers, mp_context=multiprocessing.get_context("spawn")) as pool:
        changes = repeat(options.set or [NOISY])
        runs = pool.map(
            kept_or_run, seeds, repeat(options.world), repeat(options.seconds), changes, repeat(options.output)
        )
        rows, nees = print_table(runs)
    print_summary(rows, nees)


def print_summary(rows: Sequence[Row], nees: Array) -> None:
    """Print the figures over all seeds."""
    median = {name: np.median([row[name] for row in rows]) for name in ("error_m", "odometry_m", "heading_deg")}
    print(
        f"median of the mean position error {median['error_m']:.4f} m ({median['odometry_m']:.3f} m by odometry),"
        f" of the mean heading error {median['heading_deg']:.3f} deg; average NEES"
        f" {np.mean([row['nees'] for row in rows]):.2f}"
    )
    known = np.isfinite(nees).all(axis=0)
    average = nees[:, known].mean(axis=0)
    print(f"NEES averaged over {len(rows)} seeds below 5 at {100 * np.mean(average < 5):.1f} % of ticks")
    ours, odometry = (np.mean([row[name] for row in rows]) for name in ("last_lap_m", "last_odometry_m"))
    print(f"mean error on the last lap {ours:.4f} m, {ours / odometry:.3f} of that of odometry ({odometry:.3f} m)")


if __name__ == "__main__":
    main()
