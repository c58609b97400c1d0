"""Write docs/images/camera-errors.jpg: the errors of a camera one at a time, in a view of worlds/gallery.yaml.

python scripts/make/camera_pictures.py
"""

from pathlib import Path

import cv2
import numpy as np
from sensor_pictures import HEAD, HEIGHT, WIDTH, depth_picture

import mjsim
from mjsim.interface import CameraFrame
from mjsim.sim import Canvas, OnboardCamera, Simulation, streams_of
from mjsim.video import PAPER, Letters
from mjsim.world import Camera, Robot

ROOT = Path(__file__).resolve().parents[2]
ACROSS = 4
TURN = 1.2
"""Speed at which the robot turns [rad/s]."""
ERRORS: dict[str, dict[str, object]] = {
    "as rendered": {},
    "noise: 600 e-, read-out 8 e-": {"noise": {"full_well": 600, "read": 8}},
    "exposure 2.5 ms, gain 4": {"noise": {"full_well": 600, "read": 8}, "exposure": {"seconds": 0.0025, "gain": 4}},
    "motion blur: exposure 30 ms": {"exposure": {"seconds": 0.03, "full_light": 0.03}},
    "rolling shutter: 60 ms": {"rolling_shutter": 0.06},
    "white balance: [1.3, 1, 0.7]": {"white_balance": [1.3, 1.0, 0.7]},
    "vignetting: 0.6": {"vignetting": 0.6},
    "dirt: 0.05": {"dirt": 0.05},
    "response: linear": {"response": "linear"},
    "sharpening: 2": {"sharpening": 2.0},
    "jpeg: 15": {"jpeg": 15},
    "monochrome": {"monochrome": True},
    "depth": {"depth": True},
    "depth: stereo": {"depth": {"range": [0.2, 10], "stereo": {}}},
    "preset: realsense-d435": {"preset": "realsense-d435"},
    "preset: phone": {"preset": "phone"},
}
"""Keys of a camera by the title of the picture; noise is 0 unless given."""


def camera(robot: Robot, keys: dict[str, object]) -> Camera:
    """Return the camera of a robot with other keys."""
    found = next(sensor for sensor in robot.sensors if isinstance(sensor, Camera))
    place = {"camera": found.camera, "at": found.at}
    size = {"width": WIDTH, "height": HEIGHT, "fov_deg": found.fov_deg, "noise": 0.0}
    return Camera.model_validate({**place, **({} if "preset" in keys else size), **keys})


def taken(sim: Simulation, keys: dict[str, object]) -> CameraFrame:
    """Return the picture of a camera with these keys."""
    robot = sim.world.robots[0]
    canvas = Canvas(sim.model)
    found = camera(robot, keys)
    frame = OnboardCamera(
        sim.model, robot, found, streams=streams_of(1, robot.name, found.camera), canvas=canvas
    ).frame(sim.data, 0.0)
    canvas.close()
    return frame


def main() -> None:
    """Write the picture."""
    sim = Simulation(mjsim.load_world(ROOT / "worlds" / "gallery.yaml"))
    start = int(sim.model.joint(f"{sim.world.robots[0].name}/free").dofadr[0])
    letters, tiles = Letters(), []
    for name, keys in ERRORS.items():
        sim.data.qvel[start + 5] = TURN if {"rolling_shutter", "exposure"} & set(keys) else 0.0
        frame = taken(sim, keys)
        picture = frame.image if frame.depth is None else depth_picture(frame)
        tile = np.full((HEIGHT + HEAD, WIDTH, 3), PAPER, dtype=np.uint8)
        tile[HEAD:] = cv2.resize(picture, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA)
        letters.write(tile, name, (4, 17), 14)
        tiles.append(tile)
    rows = [np.hstack(tiles[first : first + ACROSS]) for first in range(0, len(tiles), ACROSS)]
    path = ROOT / "docs" / "images" / "camera-errors.jpg"
    cv2.imwrite(str(path), cv2.cvtColor(np.vstack(rows), cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, 88])
    print(path)


if __name__ == "__main__":
    main()
