"""Draw docs/images/bring-in: maps and plans of tests/data, each beside the world that it becomes.

python scripts/make/bring_in_pictures.py
"""

from collections.abc import Sequence
from pathlib import Path

from PIL import Image

from mjsim.exchange import Reading, read_grid, read_original, with_robot, world_from_dxf, world_from_map
from mjsim.exchange.import_world import plan_of
from mjsim.video import draw_beside
from mjsim.world import World

ROOT = Path(__file__).resolve().parents[2]
PICTURES = ROOT / "docs" / "images" / "bring-in"
WIDTH = 1400
"""Size of a picture [px]."""
TILE = (690, 300)
"""Size of one of many pictures on a sheet [px]."""
MAPS = ("depot", "tb3_sandbox", "cave", "house", "drawn", "intel")
PLANS = ("office.dxf", "house.dxf", "plain.dxf", "flat.dxf", "inkscape.svg", "illustrator.svg")
SCALES = {"plain.dxf": 1.0, "illustrator.svg": 0.01}
"""Metres per unit of drawings that do not state it."""


def main() -> None:
    """Draw a map and a plan, then six of each."""
    depot, office = ROOT / "tests/data/maps/depot.yaml", ROOT / "tests/data/plans/office.dxf"
    draw("map", with_robot(world_from_map(depot), grid=read_grid(depot)), depot)
    draw("plan", with_robot(world_from_dxf(office)), office)
    sheet("maps", [ROOT / "tests/data/maps" / f"{name}.yaml" for name in MAPS])
    sheet("plans", [ROOT / "tests/data/plans" / name for name in PLANS])


def sheet(name: str, sources: Sequence[Path]) -> None:
    """Write one picture of the worlds of several maps or drawings, each beside its source, two in a row."""
    width, height = TILE
    rows = (len(sources) + 1) // 2
    page = Image.new("RGB", (2 * width, rows * height), "white")
    for number, source in enumerate(sources):
        reading = Reading(scale=SCALES.get(source.name))
        world = world_from_map(source) if source.suffix == ".yaml" else plan_of(source, reading)[0].world
        tile = Image.fromarray(draw_beside(world, read_original(source, reading=reading)))
        tile.thumbnail(TILE, Image.Resampling.LANCZOS)
        page.paste(tile, ((number % 2) * width, (number // 2) * height))
    page.quantize(224, dither=Image.Dither.NONE).save(PICTURES / f"{name}.png", optimize=True)


def draw(name: str, world: World, source: Path) -> None:
    """Write one picture."""
    page = Image.fromarray(draw_beside(world, read_original(source)))
    small = page.resize((WIDTH, round(page.height * WIDTH / page.width)), Image.Resampling.LANCZOS)
    small.quantize(224, dither=Image.Dither.NONE).save(PICTURES / f"{name}.png", optimize=True)


if __name__ == "__main__":
    main()
