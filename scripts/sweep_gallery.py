"""Run the gallery with many seeds and print how well it went: one row a seed, then medians and the average NEES.

    python scripts/sweep_gallery.py [--seeds 10] [--first 1] [--seconds S] [--workers 2] [--world FILE]

The project asks for a median of the mean position error below 0.12 m and an average NEES between 1.5 and 5.
"""

import argparse
import multiprocessing
import os
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from itertools import repeat
from pathlib import Path

import numpy as np

GALLERY = Path(__file__).resolve().parents[1] / "worlds" / "gallery.yaml"
ROBOT = "scout"
NEAR = 4.0
"""A poster that the robot passes within this distance must be in the map [m]."""
COLUMNS = {
    "seed": "4d",
    "error_m": "9.4f",
    "max_m": "8.4f",
    "odometry_m": "10.3f",
    "heading_deg": "11.3f",
    "nees": "6.2f",
    "mapped": "6d",
    "missing": "7d",
    "false": "5d",
    "worst_poster_m": "14.4f",
    "bumps": "5d",
    "x_realtime": "10.2f",
}


def run_seed(seed: int, world_file: Path, seconds: float | None) -> dict[str, float]:
    """Return the row of one seed."""
    import mjsim
    from mjsim.geometry import align_rigid

    world = mjsim.load_world(world_file)
    with mjsim.Simulation(world, seed=seed) as sim:
        recording = mjsim.run(sim, seconds=seconds)
    figures = mjsim.statistics(recording)
    own, track = figures[ROBOT], recording.robots[ROBOT]
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
    return {
        "seed": seed,
        "error_m": own["position_error_m"]["mean"],
        "max_m": own["position_error_m"]["max"],
        "odometry_m": own["odometry_error_m"]["mean"],
        "heading_deg": own["heading_error_deg"]["mean"],
        "nees": own["nees"]["mean"],
        "mapped": len(mapped),
        "missing": len(passed.difference(mapped)),
        "false": len(mapped) - len(known),
        "worst_poster_m": worst,
        "bumps": own["bumps"],
        "x_realtime": figures["run"]["real_time_factor"],
    }


def print_table(rows: Iterable[dict[str, float]]) -> list[dict[str, float]]:
    """Print rows as they come, and return them all."""
    kept = []
    print("  ".join(f"{name:>{form.split('.')[0].rstrip('df')}}" for name, form in COLUMNS.items()))
    for row in rows:
        print("  ".join(f"{row[name]:{form}}" for name, form in COLUMNS.items()), flush=True)
        kept.append(row)
    return kept


def main() -> None:
    """Run all seeds on a few processes."""
    parser = argparse.ArgumentParser(description="Run the gallery with many seeds.")
    parser.add_argument("--seeds", type=int, default=10, help="how many")
    parser.add_argument("--first", type=int, default=1, help="the first one")
    parser.add_argument("--seconds", type=float, help="simulated; as the world says unless given")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--world", type=Path, default=GALLERY)
    options = parser.parse_args()
    os.environ |= {"OMP_NUM_THREADS": "1", "LP_NUM_THREADS": "1"}  # one core a worker
    seeds = range(options.first, options.first + options.seeds)
    with ProcessPoolExecutor(options.workers, mp_context=multiprocessing.get_context("spawn")) as pool:
        rows = print_table(pool.map(run_seed, seeds, repeat(options.world), repeat(options.seconds)))
    median = {name: np.median([row[name] for row in rows]) for name in ("error_m", "odometry_m", "heading_deg")}
    print(
        f"median of the mean position error {median['error_m']:.4f} m ({median['odometry_m']:.3f} m by odometry),"
        f" of the mean heading error {median['heading_deg']:.3f} deg; average NEES"
        f" {np.mean([row['nees'] for row in rows]):.2f}"
    )


if __name__ == "__main__":
    main()
