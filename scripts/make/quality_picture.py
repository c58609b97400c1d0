"""Draw docs/images/quality.jpg: the gallery in normal and in high quality, side by side.

python scripts/make/quality_picture.py
"""

from pathlib import Path

import cv2
import numpy as np

from mjsim.bench.scenes import gallery
from mjsim.geometry import Pose
from mjsim.sim import SEEN_FROM_OUTSIDE, Renderer, Simulation
from mjsim.sim.rendering.renderer import SEEN

WIDTH, HEIGHT = 640, 480
OUT = Path(__file__).parents[2] / "docs" / "images" / "quality.jpg"
SHOTS = (
    ("scout/chase", Pose(4.9, 1.9, 0.5), SEEN_FROM_OUTSIDE),
    ("scout/front", Pose(8.3, 3.2, 1.35), SEEN),
)
"""Camera, where the robot stands, and what is seen."""


def main() -> None:
    """Draw and write it."""
    rows = []
    with Simulation(gallery()) as sim:
        for camera, place, groups in SHOTS:
            sim.move("scout", place)
            row = []
            for quality in ("normal", "high"):
                with Renderer(sim.model, width=WIDTH, height=HEIGHT, quality=quality, groups=groups) as renderer:
                    row.append(renderer.render(sim.data, camera))
            rows.append(np.hstack(row))
    cv2.imwrite(str(OUT), np.vstack(rows)[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 88])
    print(OUT)


if __name__ == "__main__":
    main()
