#!/usr/bin/env python3
"""Writes docs/images/styles.jpg: what a robot's camera sees in a room of each style.

.venv/bin/python scripts/make/style_pictures.py
"""

from pathlib import Path

import cv2
import numpy as np

from mjsim import Simulation, load_world
from mjsim.interface import Picture

PLACE = Path(__file__).resolve().parents[2] / "docs" / "images" / "styles.jpg"
ROOMS = (
    ("office", "office", "post", [8.8, 4.2], -65.0),
    ("museum", "museum", "visitor", [5.0, 3.5], 0.0),
    ("museum", "home", "visitor", [15.0, 10.5], -130.0),
    ("warehouse", "warehouse", "picker", [5.0, 15.0], 20.0),
)
"""World, style, robot, and its position [m] and heading [deg]."""


def seen(world: str, style: str, robot: str, at: list[float], heading: float) -> Picture:
    """Return a picture of the robot's first camera, RGB."""
    place = {f"robots.{robot}.at": at, f"robots.{robot}.heading_deg": heading}
    with Simulation(load_world(world, settings={"style": style, "ceiling": {}, **place})) as sim:
        return next(iter(sim.sense(robot).cameras.values())).image


def main() -> None:
    """Write the picture."""
    rows = [np.hstack([seen(*room) for room in ROOMS[first : first + 2]]) for first in (0, 2)]
    half = cv2.resize(np.vstack(rows), None, fx=0.75, fy=0.75, interpolation=cv2.INTER_AREA)
    cv2.imwrite(str(PLACE), cv2.cvtColor(half, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, 85])


if __name__ == "__main__":
    main()
