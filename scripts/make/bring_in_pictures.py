"""Draw docs/images/bring-in: a map and a plan of tests/data, each beside the world that it becomes.

python scripts/make/bring_in_pictures.py
"""

from pathlib import Path

from PIL import Image

from mjsim.exchange import read_grid, read_original, with_robot, world_from_dxf, world_from_map
from mjsim.video import draw_beside
from mjsim.world import World

ROOT = Path(__file__).resolve().parents[2]
PICTURES = ROOT / "docs" / "images" / "bring-in"
WIDTH = 1400
"""Of a picture [px]."""


def main() -> None:
    """Draw both pictures."""
    depot, office = ROOT / "tests/data/maps/depot.yaml", ROOT / "tests/data/plans/office.dxf"
    draw("map", with_robot(world_from_map(depot), grid=read_grid(depot)), depot)
    draw("plan", with_robot(world_from_dxf(office)), office)


def draw(name: str, world: World, source: Path) -> None:
    """Write one picture."""
    page = Image.fromarray(draw_beside(world, read_original(source)))
    small = page.resize((WIDTH, round(page.height * WIDTH / page.width)), Image.Resampling.LANCZOS)
    small.quantize(224, dither=Image.Dither.NONE).save(PICTURES / f"{name}.png", optimize=True)


if __name__ == "__main__":
    main()
