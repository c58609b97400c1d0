"""Draw docs/images/bring-in/robots.jpg: four robots that `mjsim new --robot-from` imports, from the tests' files.

python scripts/make/brought_pictures.py
"""

import math
import tempfile
from pathlib import Path

import cv2
import numpy as np

import mjsim
from mjsim.exchange import RobotOptions, bring_robot
from mjsim.interface import Command, Picture
from mjsim.sim import Onlooker, Orbit

ROOT = Path(__file__).resolve().parents[2]
DATA = ROOT / "tests" / "data" / "robots"
FILES = (
    "turtlebot3_description/urdf/turtlebot3_burger.urdf",
    "turtlebot3_description/urdf/turtlebot3_waffle.urdf",
    "safety_gymnasium/xmls/car.xml",
    "safety_gymnasium/xmls/racecar.xml",
)
WIDTH, HEIGHT = 480, 360
SECONDS = 1.0
"""Duration of a drive, so that steered wheels are seen to steer [s]."""


def picture(path: Path, folder: Path) -> Picture:
    """Return a picture of a robot on the move, from the left ahead."""
    brought = bring_robot(path, name=path.stem, options=RobotOptions(), packages={}, arguments={})
    for name, data in {f"{path.stem}.yaml": brought.text.encode(), **brought.files}.items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_bytes(data)
    world = mjsim.load_world(folder / f"{path.stem}.yaml")
    (robot,) = world.robots
    with mjsim.Simulation(world) as sim, Onlooker(world) as onlooker:
        sim.apply(robot.name, Command(0.2, turn=0.3))
        for _ in range(round(SECONDS / sim.dt)):
            sim.step()
        at = sim.truth(robot.name)
        onlooker.show(sim.state()[0], None)
        # The view is level with a place above small robots, so it looks down more steeply the nearer it is.
        distance = 0.4 + 2.6 * max(robot.body.radius, 0.6 * robot.body.height)
        orbit = Orbit(at.heading + math.radians(215.0), math.radians(-38.0), distance, (at.x, at.y))
        return onlooker.outside(orbit, width=WIDTH, height=2 * HEIGHT, quality="high")[HEIGHT:]


def main() -> None:
    """Draw them side by side, two by two."""
    with tempfile.TemporaryDirectory() as folder:
        pictures = [picture(DATA / name, Path(folder)) for name in FILES]
    sheet = np.vstack([np.hstack(pictures[:2]), np.hstack(pictures[2:])])
    place = ROOT / "docs" / "images" / "bring-in" / "robots.jpg"
    cv2.imwrite(str(place), sheet[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 85])
    print(place)


if __name__ == "__main__":
    main()
