"""Write docs/robots.md and docs/images/robots: dimensions, picture and driving accuracy of every robot.

python scripts/make/robot_page.py [ROBOT]...   (pictures of all robots unless some are named)
"""

import itertools
import math
import sys
from pathlib import Path

import cv2
import numpy as np

from mjsim.geometry import Pose, wrap_angle
from mjsim.interface import Command
from mjsim.sim import Simulation
from mjsim.video import take_picture
from mjsim.world import Robot, load_checked, parse_world, preset_names

ROOT = Path(__file__).resolve().parents[2]
PAGE, PICTURES, WORLDS = ROOT / "docs" / "robots.md", ROOT / "docs" / "images" / "robots", ROOT / "worlds" / "robots"
KINEMATICS = ROOT / "scripts" / "make" / "robots_head.md"
SETTLED, MEASURED = 2.5, 4.0
"""How long a robot drives before, and while it is measured [s]."""
PORTRAIT = """
mjsim: 1
floor: {{texture: floors/concrete.jpg, tile: {tile}}}
robots:
  - {{name: it, preset: {name}, at: [{x}, {y}], heading_deg: -60}}
  - {{name: photographer, at: [-{away}, -{away}], heading_deg: 45, body: {{radius: 0.02, height: 0.02}},
     sensors: [{{camera: lens, at: [0, 0, {height}], pitch_deg: -{tilt}, fov_deg: 26, width: 960, height: 600,
                 quality: high, noise: 0}}]}}
"""


def portrait(name: str) -> None:
    """Write the picture of a robot, and of its world."""
    body = Robot(name="it", preset=name, at=(0.0, 0.0)).body
    low, high = body.outline().min(axis=0), body.outline().max(axis=0)
    size = max(0.62 * math.hypot(*(high - low)), 1.35 * body.height)
    # Its middle comes to where the camera looks.
    middle = Pose(0.0, 0.0, math.radians(-60)).transform((low + high) / 2)
    away, height = 2.6 * size, 2.2 * size
    tilt = math.degrees(math.atan2(height - 0.4 * body.height, math.hypot(away, away)))
    text = PORTRAIT.format(
        name=name, x=-middle[0], y=-middle[1], away=away, height=height, tilt=tilt, tile=max(4 * size, 0.5)
    )
    for path, picture in (
        (PICTURES / f"{name}.jpg", take_picture(parse_world(text), "photographer/lens")),
        (PICTURES / f"{name}-world.jpg", take_picture(load_checked(WORLDS / f"{name}.yaml"), "overview")),
    ):
        small = cv2.resize(picture, None, fx=640 / picture.shape[1], fy=640 / picture.shape[1], interpolation=3)
        cv2.imwrite(str(path), cv2.cvtColor(small, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, 85])


def measured(name: str, command: Command) -> tuple[float, float, float]:
    """Return the distance [m], the turn [rad] and the drift of odometry [m] while a robot follows a command."""
    with Simulation(parse_world(f"mjsim: 1\nrobots: [{{name: it, preset: {name}, at: [0, 0]}}]\n")) as sim:
        sim.apply("it", command)
        for _ in range(round(SETTLED / sim.dt)):
            sim.step()
        path, told = [sim.truth("it")], Pose(0.0, 0.0, 0.0)
        for _ in range(round(MEASURED / sim.dt)):
            sim.step()
            path.append(sim.truth("it"))
            seen = sim.odometry("it")
            told = told @ Pose(seen.forward, seen.left, seen.turn)
    steps = list(itertools.pairwise(path))
    way = sum(math.hypot(b.x - a.x, b.y - a.y) for a, b in steps)
    turn = sum(wrap_angle(b.heading - a.heading) for a, b in steps)
    error = told.inverse() @ (path[0].inverse() @ path[-1])
    return way, turn, math.hypot(error.x, error.y)


def accuracy(name: str) -> str:
    """Return a row of the table of how well a robot drives."""
    drive = Robot(name="it", preset=name, at=(0.0, 0.0)).drive
    speed = 0.6 * drive.max_speed
    turn = min(0.4 * math.radians(drive.max_turn_deg), 0.5)
    straight, _, _ = measured(name, Command(speed))
    cells = [f"{straight / (speed * MEASURED) * 100 - 100:+.2f} %"]
    if drive.type == "ackermann":
        cells.append("cannot")
    else:
        _, spun, _ = measured(name, Command(turn=turn))
        cells.append(f"{spun / (turn * MEASURED) * 100 - 100:+.2f} %")
    way, turned, drift = measured(name, Command(0.5 * speed, turn=0.8 * turn))
    ideal = 0.5 * speed / (0.8 * turn)
    cells.append(f"{way / turned / ideal * 100 - 100:+.2f} %")
    cells.append(f"{1000 * drift / way:.1f} mm/m")
    if drive.type in ("omni3", "mecanum"):
        aside, _, _ = measured(name, Command(left=speed))
        cells.append(f"{aside / (speed * MEASURED) * 100 - 100:+.2f} %")
    else:
        cells.append("cannot")
    return f"| `{name}` | {' | '.join(cells)} |\n"


def sizes(name: str) -> str:
    """Return a row of the table of sizes."""
    robot = Robot(name="it", preset=name, at=(0.0, 0.0))
    drive, body = robot.drive, robot.body
    low, high = body.outline().min(axis=0), body.outline().max(axis=0)
    length, width = np.round(high - low, 3).tolist()
    limits = f"{drive.max_speed:g} m/s, {drive.max_turn_deg:g} deg/s"
    return (
        f"| [`{name}`](../assets/robots/{name}.yaml) | {drive.type} | {length:g} x {width:g} x {body.height:g} |"
        f" {body.mass:g} | {drive.wheel_radius:g} | {limits} |\n"
    )


def page() -> str:
    """Return the page."""
    text = KINEMATICS.read_text(encoding="utf-8")
    text += "\n## Sizes\n\n| preset | drive | length x width x height [m] | mass [kg] | wheel radius [m] | limits |\n"
    text += "|---|---|---|---|---|---|\n" + "".join(sizes(name) for name in preset_names())
    text += (
        "\nThe preset files give the source of each value.\n\n## Driving accuracy\n\n"
        "Deviation from the ideal motion, measured on a level floor with friction 1 and without noise\n"
        "(`python scripts/make/robot_page.py`): distance straight ahead, turn on the spot, radius of a circle,\n"
        "odometry error per metre on that circle, and distance sideways.\n\n"
        "| preset | straight | on the spot | circle | odometry | sideways |\n|---|---|---|---|---|---|\n"
    )
    text += "".join(accuracy(name) for name in preset_names())
    for name in preset_names():
        text += f"\n## {name}\n\n![{name}](images/robots/{name}.jpg)\n\n"
        text += f"```sh\n.venv/bin/mjsim run worlds/robots/{name}.yaml\n```\n\n"
        text += f"![The world of {name}](images/robots/{name}-world.jpg)\n"
    return text


def main() -> None:
    """Write the page and the pictures."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    for name in sys.argv[1:] or preset_names():
        portrait(name)
        print(name)
    PAGE.write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    main()
