"""Draw the figures of docs/tutorials/control-lessons.md: one plot of the laboratory for each of its worlds.

python scripts/make/lab_pictures.py
"""

import tempfile
from functools import partial
from pathlib import Path

from mjsim.lab import lead_design, lqr_design, pid_design, placed_design, write_lab
from mjsim.world import load_world

ROOT = Path(__file__).resolve().parents[2]
STEPS = {
    "lab-1-step": ("motor", "step", []),
    "lab-2-sweep": ("motor", "identification", []),
    "lab-3-margins": ("lags", "bode", []),
    "lab-4-speed": ("motor", "design_1", [partial(pid_design, rule="simc")]),
    "lab-5-joint": ("elbow", "design_1", [partial(lead_design, margin_deg=45.0, crossover=6.0)]),
    "lab-6-cart": ("hanging", "step", []),
    "lab-7-place": ("body", "design_1", [partial(placed_design, poles=[-3.0, -3.0, -4.0, -8.06])]),
    "lab-8-lqr": ("body", "design_1", [partial(lqr_design, weights=[20.0, 20.0, 5.0, 2.0], effort=0.2)]),
}
"""World -> plant, plot, and the controllers that are designed for it."""


def main() -> None:
    """Write them to docs/images."""
    for name, (plant, plot, designers) in STEPS.items():
        world = load_world(ROOT / "worlds" / "lab" / f"{name}.yaml")
        with tempfile.TemporaryDirectory() as folder:
            write_lab(world, Path(folder), plant=plant, designers=designers)
            picture = (Path(folder) / f"{plant}_{plot}.png").read_bytes()
        path = ROOT / "docs" / "images" / f"{name}.png"
        path.write_bytes(picture)
        print(path)


if __name__ == "__main__":
    main()
