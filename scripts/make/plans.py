"""Draw the DXF plans of tests/data/plans, as CAD programs export them; ezdxf writes them, without mjsim.

python scripts/make/plans.py
"""

import itertools
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import ezdxf

PLANS = Path(__file__).resolve().parents[2] / "tests" / "data" / "plans"


class Office:
    """An office as American offices draw: AIA layers, millimetres, far from the origin, doors as blocks."""

    layers = ("A-WALL", "A-DOOR", "A-GLAZ", "A-FURN", "A-ANNO-DIMS", "A-ANNO-TEXT", "A-FLOR-STRS", "A-WALL-PATT")
    origin = (512_000.0, 208_000.0)

    def __init__(self) -> None:
        self.document = ezdxf.new("R2000", units=4)
        self.space = self.document.modelspace()
        for layer in self.layers:
            self.document.layers.add(layer)

    def at(self, x: float, y: float) -> tuple[float, float]:
        """Return a point of the drawing from one of the office [mm]."""
        return self.origin[0] + x, self.origin[1] + y

    def line(self, x1: float, y1: float, x2: float, y2: float, layer: str = "A-WALL") -> None:
        """Draw a line between two points [mm]."""
        self.space.add_line(self.at(x1, y1), self.at(x2, y2), dxfattribs={"layer": layer})

    def broken_line(self, y: float, ends: Sequence[float]) -> None:
        """Draw a line along x with gaps: from the first end to the second, from the third to the fourth, ..."""
        for start, end in zip(ends[::2], ends[1::2], strict=True):
            self.line(start, y, end, y)

    def outer_walls(self) -> None:
        """Walls of 300 mm, a room of 14.4 m x 9 m inside, with windows between jambs in the south wall."""
        for x1, y1, x2, y2 in ((0, 0, 0, 9600), (0, 9600, 15000, 9600), (15000, 9600, 15000, 0)):
            self.line(x1, y1, x2, y2)
        windows = [(1500, 3300), (5000, 6800), (9000, 10800)]
        jambs = [x for pair in windows for x in pair]
        self.broken_line(0, [0, *jambs, 15000])
        self.broken_line(300, [300, *jambs, 14700])
        for start, end in windows:
            for x in (start, end):
                self.line(x, 0, x, 300)
            for y in (0, 110, 190, 300):
                self.line(start, y, end, y, "A-GLAZ")
        self.line(300, 300, 300, 9300)
        self.line(14700, 300, 14700, 9300)

    def corridor(self) -> None:
        """Walls of 120 mm between y = 5000 and 6800 with gaps for doors, and the walls between the rooms."""
        doors = {5000: [1800, 2700, 6200, 7100, 11000, 11900], 6800: [3000, 3900, 9000, 9900]}
        for y, jambs in doors.items():
            for face in (y - 60, y + 60):
                self.broken_line(face, [300, *jambs, 14700])
            for x in jambs:
                self.line(x, y - 60, x, y + 60)
        for x, low, high in ((4800, 300, 4940), (9600, 300, 4940), (7300, 6860, 9300)):
            self.line(x - 60, low, x - 60, high)
            self.line(x + 60, low, x + 60, high)
        self.line(300, 9300, 7240, 9300)
        self.line(7360, 9300, 14700, 9300)

    def doors(self) -> None:
        """Doors of 900 mm as blocks, turned and mirrored."""
        door = self.document.blocks.new("DOOR-900")
        door.add_line((0, 0), (0, 900))
        door.add_arc((0, 0), 900, 0, 90)
        for (x, y), turn, mirrored in (
            ((1800, 4940), 180, True), ((6200, 4940), 180, True), ((11900, 4940), 180, False),
            ((3000, 6860), 0, False), ((9900, 6860), 0, True),
        ):  # fmt: skip
            self.space.add_blockref("DOOR-900", self.at(x, y), dxfattribs={
                "layer": "A-DOOR", "rotation": turn, "xscale": -1 if mirrored else 1,
            })  # fmt: skip

    def furniture(self) -> None:
        """Desks as blocks, and a round table."""
        desk = self.document.blocks.new("DESK_1600x800")
        desk.add_lwpolyline([(0, 0), (1600, 0), (1600, 800), (0, 800)], close=True)
        desk.add_circle((800, 1100), 250)
        for x, y, turn in ((700, 1200, 0), (5600, 1500, 90), (12500, 1500, 30), (2000, 8000, 180)):
            self.space.add_blockref("DESK_1600x800", self.at(x, y), dxfattribs={"layer": "A-FURN", "rotation": turn})
        self.space.add_circle(self.at(10500, 8100), 600, dxfattribs={"layer": "A-FURN"})

    def what_is_no_wall(self) -> None:
        """Draw stairs, the hatching of a wall, a dimension, a text, and the frame of the sheet: none is a wall."""
        for step in range(10):
            self.line(13000 + 170 * step, 7000, 13000 + 170 * step, 8200, "A-FLOR-STRS")
        for offset in range(0, 14400, 200):
            self.line(300 + offset, 9300, 600 + offset, 9600, "A-WALL-PATT")
        self.space.add_linear_dim(
            base=self.at(0, -1500), p1=self.at(0, 0), p2=self.at(15000, 0), dimstyle="Standard",
            dxfattribs={"layer": "A-ANNO-DIMS"},
        ).render()  # fmt: skip
        self.space.add_mtext("OFFICE 1", dxfattribs={"layer": "A-ANNO-TEXT", "insert": self.at(2000, 3000)})
        frame = [self.at(*corner) for corner in ((-3000, -4000), (20000, -4000), (20000, 12000), (-3000, 12000))]
        self.space.add_lwpolyline(frame, close=True, dxfattribs={"layer": "G-TITL-BORDER"})


def office() -> Any:
    """Return an office as American offices draw."""
    drawn = Office()
    drawn.outer_walls()
    drawn.corridor()
    drawn.doors()
    drawn.furniture()
    drawn.what_is_no_wall()
    return drawn.document


def house() -> Any:
    """Return a house as German offices draw: centimetres, closed outlines, insulated outer walls, arcs by bulges."""
    document = ezdxf.new("R2000", units=5)
    space = document.modelspace()
    for layer in ("AR_Mauerwerk", "AR_Tueren", "AR_Fenster", "AR_Moebel", "Bemassung", "Achsen", "Stuetzen", "Treppe"):
        document.layers.add(layer)

    def ring(points: Any, layer: str = "AR_Mauerwerk") -> None:
        space.add_lwpolyline(points, close=True, dxfattribs={"layer": layer})

    # Three lines: facing, insulation, masonry; 11.5 + 10 + 17.5 = 39 cm in all, 900 x 750 outside.
    for inset in (0.0, 11.5, 21.5, 39.0):
        ring([(inset, inset), (900 - inset, inset), (900 - inset, 750 - inset), (inset, 750 - inset)])
    # Inner walls as closed outlines, ends a little short of the outer wall or over it.
    ring([(400, 39.8), (411.5, 39.8), (411.5, 300), (400, 300)])
    ring([(400, 388.5), (411.5, 388.5), (411.5, 712), (400, 712)])
    ring([(411.5, 430), (560, 430), (560, 441.5), (411.5, 441.5)])
    ring([(648.5, 430), (861, 430), (861, 441.5), (648.5, 441.5)])
    quarter = math.tan(math.pi / 8)
    # A leaf and its way as one polyline: hinge, end of the open leaf, and with a bulge the other jamb.
    space.add_lwpolyline(
        [(400, 300, 0), (311.5, 300, quarter * -1), (400, 388.5, 0)],
        format="xyb", dxfattribs={"layer": "AR_Tueren"},
    )  # fmt: skip
    space.add_lwpolyline(
        [(560, 441.5, 0), (560, 530, -quarter), (648.5, 441.5, 0)],
        format="xyb", dxfattribs={"layer": "AR_Tueren"},
    )  # fmt: skip
    # The front door in the outer wall, over lines that go on.
    space.add_lwpolyline(
        [(150, 39, 0), (150, 140, -quarter), (251, 39, 0)], format="xyb", dxfattribs={"layer": "AR_Tueren"}
    )
    for x in (550, 700):
        ring([(x, 0), (x + 120, 0), (x + 120, 39), (x, 39)], "AR_Fenster")
    ring([(600, 600), (630, 600), (630, 630), (600, 630)], "Stuetzen")
    ring([(60, 600), (260, 600), (260, 700), (60, 700)], "AR_Moebel")
    space.add_circle((750, 250), 55, dxfattribs={"layer": "AR_Moebel"})
    for step in range(9):
        space.add_line((430 + 27 * step, 60), (430 + 27 * step, 150), dxfattribs={"layer": "Treppe"})
    for x in (0, 405, 900):
        space.add_line((x, -200), (x, 950), dxfattribs={"layer": "Achsen"})
    space.add_text("Wohnen 24,3 m2", dxfattribs={"layer": "Bemassung", "insert": (100, 300), "height": 20})
    return document


def plain() -> Any:
    """Return a flat on layer 0 alone, in metres, as simple programs export: two faces, doors, stairs, a frame."""
    document = ezdxf.new("R12")
    document.header["$INSUNITS"] = 6
    space = document.modelspace()

    def lines(*points: tuple[float, float]) -> None:
        for start, end in itertools.pairwise(points):
            space.add_line(start, end)

    lines((0, 0), (8, 0), (8, 6), (0, 6), (0, 0))
    # Inner faces, 20 cm in; a partition of 10 cm at x = 5 with a door of 0.8 m, corners 1 cm open or over.
    lines((0.2, 0.2), (4.95, 0.2), (4.95, 2.0))
    lines((4.95, 2.8), (4.95, 5.8), (0.21, 5.8))
    lines((0.2, 5.81), (0.2, 0.19))
    lines((5.05, 2.0), (5.05, 0.2), (7.8, 0.2), (7.8, 5.8), (5.05, 5.8), (5.05, 2.8))
    lines((4.95, 2.0), (5.05, 2.0))
    lines((4.95, 2.8), (5.05, 2.8))
    lines((5.05, 2.0), (5.85, 2.0))
    space.add_arc((5.05, 2.0), 0.8, 0, 90)
    # A front door drawn over the wall, whose lines go on.
    space.add_arc((1.0, 0.2), 0.9, 0, 90)
    lines((1.0, 0.2), (1.0, 1.1))
    for step in range(8):
        lines((5.4 + 0.28 * step, 4.7), (5.4 + 0.28 * step, 5.7))
    # The frame of the sheet with its title block, and a scale bar.
    for x, y, width, height in ((-3, -4, 14, 12), (6, -4, 5, 1.5), (-1, -2, 1, 0.1), (0, -2, 1, 0.1), (1, -2, 1, 0.1)):
        space.add_polyline2d([(x, y), (x + width, y), (x + width, y + height), (x, y + height)], close=True)
    space.add_text("SCALE 1:100", dxfattribs={"insert": (6.2, -3.2), "height": 0.3})
    return document


def main() -> None:
    """Write all plans."""
    for draw in (office, house, plain):
        document = draw()
        document.saveas(PLANS / f"{draw.__name__}.dxf")


if __name__ == "__main__":
    main()
