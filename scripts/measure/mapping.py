#!/usr/bin/env python3
"""Measure what programs of others make of a drive, plain and baked: COLMAP's maps, and Open3D's dense RGB-D odometry.

.venv/bin/python scripts/measure/mapping.py [WORLD ...] [--seconds 30] [--rate 12.5] [--set KEY=VALUE ...]

A world drives as it is written, but with exact odometry in place of observers. Its first camera takes pictures with
depth and with its own noise; COLMAP gets every fourth.

- `models`, `registered`: how many maps COLMAP makes, and the share of its pictures that the largest one holds.
- `RMSE`: of positions in the largest map after alignment with scale [m].
- `odometry`: error of Open3D's odometry from picture to picture, mean [mm] and largest [mm], and of the whole way [%].
"""

import argparse
import json
import subprocess
import sys
import tempfile
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
from features import exact, exact_drivers
from scipy.spatial.transform import RigidTransform, Rotation

import mjsim
from mjsim.datasets import export_tum_rgbd
from mjsim.geometry import Array
from mjsim.world import World, load_world

SHADINGS = ("plain", "baked")
EACH = 4
"""COLMAP gets one picture of so many."""


def main() -> None:
    """Print a row for each world and shading."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("worlds", nargs="*", default=["office"], help="names or files")
    parser.add_argument("--seconds", type=float, default=30.0, help="of each drive [s]")
    parser.add_argument("--rate", type=float, default=12.5, help="of pictures [Hz]")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="a setting of the world")
    parser.add_argument("--only", nargs=2, metavar=("PROGRAM", "FOLDER"), help=argparse.SUPPRESS)
    chosen = parser.parse_args()
    if chosen.only:
        program, folder = chosen.only
        print(json.dumps({"colmap": colmap, "open3d": dense_odometry}[program](Path(folder))))
        return
    settings = dict(each.split("=", 1) for each in chosen.set)
    print("| world | shading | way | pictures | models | registered | RMSE | odometry: mean | largest | whole way |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for name in chosen.worlds:
        for shading in SHADINGS:
            world = load_world(name, settings={**settings, "shading": shading})
            with tempfile.TemporaryDirectory() as folder:
                place = drive(world, Path(folder), seconds=chosen.seconds, rate=chosen.rate)
                maps, odometry = (_in_own_process(program, place) for program in ("colmap", "open3d"))
            print(f"| {Path(name).stem} | {shading} | {maps} | {odometry} |", flush=True)


def drive(world: World, folder: Path, *, seconds: float, rate: float) -> Path:
    """Drive, and return the folder of a TUM RGB-D data set of what the first camera saw."""
    world = exact(world, rate_hz=rate, depth=True)
    with mjsim.Simulation(world, seed=1) as sim:
        run = mjsim.run(sim, drivers=exact_drivers(world), seconds=seconds, record=folder / "run.mcap")
    return export_tum_rgbd(run, folder / "tum", redraw=True)[0]


def colmap(place: Path) -> str:
    """Return the cells of a table that COLMAP's maps of every fourth picture fill."""
    import pycolmap
    from evo.core.geometry import umeyama_alignment

    pycolmap.logging.minloglevel = pycolmap.logging.ERROR
    times = _stamps(place / "rgb.txt")
    names = [name for _, name in times][::EACH]
    reader, features = pycolmap.ImageReaderOptions(), pycolmap.FeatureExtractionOptions()
    fx, fy, cx, cy = _calibration(place)
    reader.camera_model, reader.camera_params = "PINHOLE", f"{fx},{fy},{cx + 0.5},{cy + 0.5}"  # pixels from the corner
    features.num_threads = 2
    database, processor = place / "all.db", pycolmap.Device.cpu
    pycolmap.extract_features(database, place, names, pycolmap.CameraMode.SINGLE, reader, features, processor)
    pycolmap.match_exhaustive(database, device=processor)
    options = pycolmap.IncrementalPipelineOptions()
    options.ba_refine_focal_length = options.ba_refine_extra_params = False
    maps = pycolmap.incremental_mapping(database, place, place, options=options).values()
    way = np.linalg.norm(np.diff(_true_poses(place, times).translation, axis=0), axis=1).sum()
    cells = f"{way:.1f} m | {len(names)} | {len(maps)}"
    if not maps:
        return f"{cells} | 0 % | none"
    largest = max(maps, key=lambda each: each.num_reg_images())
    found = {each.name: each.cam_from_world().inverse().translation for each in largest.images.values()}
    truth = _true_poses(place, [(time, name) for time, name in times if name in found]).translation
    places = np.array([found[name] for _, name in times if name in found])
    turn, moved, scale = umeyama_alignment(places.T, truth.T, with_scale=True)
    rmse = np.sqrt(((scale * places @ turn.T + moved - truth) ** 2).sum(axis=1).mean())
    return f"{cells} | {100 * len(found) / len(names):.0f} % | {rmse:.3f} m"


def dense_odometry(place: Path) -> str:
    """Return the cells of a table that Open3D's odometry from picture to picture fills."""
    import open3d

    times, depths = _stamps(place / "rgb.txt"), _stamps(place / "depth.txt")
    frames = [_frame(place, color, depth) for (_, color), (_, depth) in zip(times, depths, strict=True)]
    height, width = cv2.imread(str(place / times[0][1])).shape[:2]
    camera = open3d.camera.PinholeCameraIntrinsic(width, height, *_calibration(place))
    term = open3d.pipelines.odometry.RGBDOdometryJacobianFromHybridTerm()
    steps = []
    for last, now in pairwise(frames):
        _, step, _ = open3d.pipelines.odometry.compute_rgbd_odometry(now, last, camera, np.eye(4), term)
        steps.append(RigidTransform.from_matrix(step))
    truth = _true_poses(place, times)
    truly = truth[:-1].inv() * truth[1:]
    off = np.linalg.norm([(a.inv() * b).translation for a, b in zip(truly, steps, strict=True)], axis=1)
    whole = steps[0]
    for step in steps[1:]:
        whole = whole * step
    end = np.linalg.norm(((truth[0].inv() * truth[-1]).inv() * whole).translation)
    way = np.linalg.norm(truly.translation, axis=1).sum()
    return f"{1000 * off.mean():.1f} mm | {1000 * off.max():.0f} mm | {100 * end / way:.1f} %"


def _frame(place: Path, color: str, depth: str) -> object:
    """Return a picture with its depth, as Open3D has them."""
    import open3d

    read = open3d.io.read_image
    return open3d.geometry.RGBDImage.create_from_color_and_depth(
        read(str(place / color)), read(str(place / depth)), depth_scale=5000.0, depth_trunc=8.0
    )


def _in_own_process(program: str, place: Path) -> str:
    """Return what a program of others makes of a data set; their libraries do not always agree."""
    command = [sys.executable, __file__, "--only", program, str(place)]
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    return str(json.loads(done.stdout.splitlines()[-1]))


def _stamps(file: Path) -> list[tuple[float, str]]:
    """Return the time [s] and the name of each picture of a list."""
    rows = (line.split() for line in file.read_text().splitlines() if not line.startswith("#"))
    return [(float(stamp), name) for stamp, name in rows]


def _true_poses(place: Path, times: list[tuple[float, str]]) -> RigidTransform:
    """Return where the camera was, and how it was turned."""
    truth = np.loadtxt(place / "groundtruth.txt")
    rows: Array = truth[[np.abs(truth[:, 0] - time).argmin() for time, _ in times]]
    return RigidTransform.from_components(rows[:, 1:4], Rotation.from_quat(rows[:, 4:]))


def _calibration(place: Path) -> tuple[float, ...]:
    """Return fx, fy, cx, cy [px]; pixels are counted from the centre of the first."""
    numbers = dict(line.split(": ") for line in (place / "camera.yaml").read_text().splitlines()[1:])
    return tuple(float(numbers[f"Camera.{key}"]) for key in ("fx", "fy", "cx", "cy"))


if __name__ == "__main__":
    main()
