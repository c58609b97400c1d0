"""Write docs/images/sensors.jpg: what the cameras and the lidar of worlds/sensors.yaml give, each with its name.

python scripts/make/sensor_pictures.py
"""

from pathlib import Path

import cv2
import numpy as np

import mjsim
from mjsim.geometry import Pose
from mjsim.interface import CameraFrame, Picture, Scan
from mjsim.plan import PlanItem, placed_at, world_shapes
from mjsim.run import drivers_of
from mjsim.video import PAPER, Letters
from mjsim.video.beam_points import scan_points
from mjsim.video.paper import Paper
from mjsim.video.plan_parts import floor_color
from mjsim.video.plan_view import PlanView

ROOT = Path(__file__).resolve().parents[2]
WIDTH, HEIGHT, HEAD = 320, 240, 24
SECONDS = 12.0
"""When they are taken."""
FAR = 8.0
"""Distance from which everything is darkest in the picture of depths [m]."""


def newest() -> tuple[dict[str, CameraFrame], Scan, Pose, mjsim.Simulation]:
    """Return the newest picture of each camera after a while, the scan, and where the robot is."""
    world, cameras = mjsim.load_world(ROOT / "worlds" / "sensors.yaml"), {}
    sim = mjsim.Simulation(world)
    for tick in mjsim.ticks(sim, drivers_of(world)):
        seen = tick.seen["scout"]
        cameras |= seen.cameras
        if tick.time >= SECONDS and seen.scans:
            return cameras, seen.scans["scan"], tick.truth["scout"], sim
    raise AssertionError("the loop goes on for ever")


def depth_picture(frame: CameraFrame) -> Picture:
    """Return depths as grey values, near ones bright, unmeasured ones black."""
    assert frame.depth is not None
    known = np.isfinite(frame.depth)
    bright = np.where(known, np.clip(255 - 220 * np.where(known, frame.depth, 0.0) / FAR, 35, 255), 0).astype(np.uint8)
    return np.repeat(bright[..., None], 3, axis=2)


def instance_picture(frame: CameraFrame) -> Picture:
    """Return each instance in a colour of its own."""
    assert frame.segmentation is not None
    hues = np.arange(len(frame.instances) + 1) * 137.5 % 180
    colors = cv2.cvtColor(
        np.stack([hues, hues * 0 + 130, hues * 0 + 210], -1).astype(np.uint8)[None], cv2.COLOR_HSV2RGB
    )
    colors[0, -1] = 0  # -1: nothing.
    return np.asarray(colors[0][frame.segmentation], dtype=np.uint8)


def scan_picture(scan: Scan, truth: Pose, sim: mjsim.Simulation) -> Picture:
    """Return the plan with the points of the scan."""
    page = np.full((HEIGHT, WIDTH, 3), floor_color(sim.world), dtype=np.uint8)
    view = PlanView.fit([[-0.3, -0.3], [9.3, 7.3]], WIDTH, HEIGHT, margin=4)
    paper = Paper(page, view, Letters(), 6.0)
    mount = sim.robots["scout"].sensors["scan"].robot_from_sensor
    points = scan_points(scan, mount, truth.as_array())
    paper.draw(placed_at(world_shapes(sim.world), {"robot/scout": truth}))
    paper.draw([PlanItem(role="scan", kind="dots", parts=(points,))])
    return page


def main() -> None:
    """Write the picture."""
    cameras, scan, truth, sim = newest()
    with sim:
        parts = {
            "front": cv2.resize(cameras["front"].image, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA),
            "fisheye: lens of 150 degrees": cameras["fisheye"].image,
            "cheap: lens, shutter, noise": cameras["cheap"].image,
            "depth: depth": depth_picture(cameras["depth"]),
            "depth: segmentation": instance_picture(cameras["depth"]),
            "scan: points": scan_picture(scan, truth, sim),
        }
    letters, tiles = Letters(), []
    for name, picture in parts.items():
        tile = np.full((HEIGHT + HEAD, WIDTH, 3), PAPER, dtype=np.uint8)
        tile[HEAD:] = picture
        letters.write(tile, name, (4, 17), 14)
        tiles.append(tile)
    page = np.vstack([np.hstack(tiles[:3]), np.hstack(tiles[3:])])
    path = ROOT / "docs" / "images" / "sensors.jpg"
    cv2.imwrite(str(path), cv2.cvtColor(page, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, 85])
    print(path)


if __name__ == "__main__":
    main()
