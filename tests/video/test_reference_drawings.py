"""Drawings look as they did when a person last looked at them: each is compared with a reduced picture of it.

`python -m tests.video.test_reference_drawings` draws the references again, after a drawing was changed on purpose: look
at them before they are committed.
"""

import re
import sys
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import cv2
import numpy as np
import pytest

from mjsim.geometry import Pose
from mjsim.plan import PlanItem, SvgPlan, bounds_of, world_shapes, world_words
from mjsim.video.diagrams import DiagramFrame, diagrams_page
from mjsim.video.film_frame import Frame, PlanFrame, draw_seen
from mjsim.video.ink import Letters
from mjsim.video.original_beside import draw_beside
from mjsim.video.people_figures import people_page
from mjsim.video.sheet import draw_world
from mjsim.world import Looks, View, load_world, parse_world
from tests.video.test_video_frame import NOW

REFERENCE = Path(__file__).parent / "reference"
WORLDS = Path(__file__).parents[2] / "worlds"
BLOCK = 8
"""Side of the square of pixels of which a reference has the mean [px]."""
MOST = 20
"""A mean that differs by more is another drawing: a line through a block changes it by 50, another font's edge by 5."""
PLAN = """
mjsim: 1
name: everything
floor: {patches: [{at: [2, 5], size: [1.5, 1], color: "#93a878"}]}
walls:
  - points: [[0, 0], [9, 0], [9, 6], [0, 6]]
    closed: true
    thickness: 0.2
    openings:
      - {name: door, segment: 0, at: 3, width: 1, door: {hinge: left}}
      - {name: ajar, segment: 1, at: 2, width: 0.8, door: {angle_deg: 30}}
      - {segment: 2, at: 2, width: 2, sill: 0.9, head: 2.0}
  - {points: [[6, 0], [6, 2]], height: 0.8}
obstacles:
  - {name: crate, box: [1, 0.6, 1], at: [7.5, 4.5], heading_deg: 20, color: "#4060c0"}
  - {name: cart, box: [0.5, 0.5, 0.6], at: [4.5, 5], movable: true, mass: 5}
  - {name: post, cylinder: [0.3, 1.5], at: [8, 1]}
  - {name: lamp, box: [0.6, 0.6, 0.1], at: [5, 3], elevation: 1.8}
  - {name: ramp, ramp: [1.4, 0.8, 0.2], at: [1.2, 1.2], heading_deg: 90}
  - {name: stair, steps: [1.2, 0.8, 0.4], count: 4, at: [3, 1.2]}
  - {name: bus, box: [0.4, 0.3, 0.9], at: [2, 4], path: {points: [[4, 4], [4, 3]], speed: 0.5, closed: true}}
beacons:
  - {name: lion, image: posters/lion.jpg, at: [0.11, 3], width: 0.6}
  - {name: tag, marker: {dictionary: 4x4_50, id: 7}, at: [8.89, 3], heading_deg: 180}
  - {name: foil, width: 0.05, at: [5.9, 1], heading_deg: 180}
  - {name: mast, anchor: true, at: [4.5, 0.5]}
lamps: [{name: sun, at: [6.5, 3.5]}, {name: off, at: [7, 3.5], brightness: 0}]
robots:
  - {name: scout, at: [2, 2.6], heading_deg: 30, sensors: [{camera: front}]}
  - name: other
    base: fixed
    at: [8, 5.3]
    arms: [{name: arm, dh: {rows: [{a: 0.5}, {a: 0.3}]}, start_deg: [200, 60]}]
run: {seconds: 10}
"""


TURNED = Pose(0.0, 0.0, 0.3)


@dataclass(frozen=True)
class Line:
    points: np.ndarray
    closed: bool = False
    dark: float | None = None
    path: int = 0


@dataclass(frozen=True)
class Map:
    name: str = "map.png"
    bounds: np.ndarray = None
    strokes: tuple = ()
    picture: np.ndarray | None = None
    cell: float = 0.5
    world_from_picture: Pose = TURNED


PATHS = [
    PlanItem(role="true path", kind="line", parts=(np.array([[1.0, 1.0], [3.0, 2.0]]),), of="scout"),
    PlanItem(role="landmark", kind="dots", parts=(np.array([[1.0, 1.5], [3.0, 2.5]]),)),
]
SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
DRAWING = Map(
    "plan.dxf",
    np.array([[0.0, 0.0], [9.0, 6.0]]),
    (
        Line(SQUARE * 4 + 1, closed=True, dark=0.8, path=1),
        Line(SQUARE * 2 + 2, closed=True, dark=0.8, path=1),
        Line(SQUARE * (2, 3) + (6, 1), closed=True, dark=0.2, path=2),
        Line(np.array([[0.5, 5.5], [5.0, 5.8], [8.5, 5.0]])),
    ),
)
IMAGE = np.repeat(np.random.default_rng(3).integers(0, 255, (8, 12, 1)), 3, axis=2).astype(np.uint8)
SCAN = Map(bounds=np.array([[-2.0, 0.0], [6.0, 6.0]]), picture=IMAGE)
LATER = replace(
    NOW,
    time=4.0,
    truth=np.array([3.0, 2.5, 0.4]),
    odometry=np.array([6.5, 2.0, 0.2]),
    estimate=np.array([4.5, 3.5, 1.2]),
    others={"other": np.array([8.0, 5.3, 0.0])},
    looks=Looks(light=1.0, lamps={"sun": 0.5, "off": 0.0}),
    scans={"lidar": np.array([[5.0, 4.0], [6.0, 4.5], [0.2, 2.0]])},
    arms={"other/arm": np.array([0.0, 1.0])},
)


@cache
def world(name):
    return parse_world(PLAN) if name == "everything" else load_world(WORLDS / name)


def film(moments=(NOW, LATER), **more):
    frame = Frame(world("everything"), "scout", seconds=10.0, display=View(), **more)
    for moment in moments:
        frame.add(replace(moment, others=LATER.others))
    return frame.draw(moments[-1])


def plan_film(moment=LATER, **look):
    frame = PlanFrame(world("everything"), "scout", display=View(**look))
    frame.add(replace(NOW, others=LATER.others))
    frame.add(moment)
    return frame.draw(moment)


def seen():
    image = np.full((300, 400, 3), 30, np.uint8)
    far = replace(NOW.sightings[0], name="owl", corners=NOW.sightings[0].corners * 0.5 + 250)
    draw_seen(image, replace(NOW, sightings=(*NOW.sightings, far)), Letters())
    return image


def moving():
    found = world("mechanisms/press.yaml")
    starts = {item.name: item.assembly.start for item in found.mechanisms}
    frame = DiagramFrame(found, {name: np.stack([start, start]) for name, start in starts.items()})
    return frame.draw(2.5, starts)


DRAWINGS = {
    "plan": lambda: draw_world(world("everything"), labels="all"),
    **{
        f"diagrams-{name}": lambda name=name: diagrams_page(world(f"mechanisms/{name}.yaml"), 1500, names=True)
        for name in ("joints", "linkages", "curves", "control", "turnstile")
    },
    "diagrams-moving": moving,
    **{
        f"people-{name}": lambda name=name: people_page(world(f"people/{name}.yaml"), 1600, names=True)
        for name in ("control_desk", "driving_seat")
    },
    "film": film,
    "film-start": lambda: film((NOW,)),
    "film-plan": plan_film,
    "film-bump": lambda: plan_film(
        replace(
            LATER,
            touched=True,
            scans={},
            looks=Looks(light=1.0, lamps={"sun": 1.0, "off": 1.0}, removed=frozenset({"crate"})),
        )
    ),
    "seen": seen,
    "beside-drawing": lambda: draw_beside(world("everything"), DRAWING, labels="none"),
    "beside-map": lambda: draw_beside(world("everything"), SCAN, labels="none"),
}


def reduced(picture):
    """The mean of each block of a picture."""
    height, width = (size // BLOCK * BLOCK for size in picture.shape[:2])
    return cv2.resize(picture[:height, :width], (width // BLOCK, height // BLOCK), interpolation=cv2.INTER_AREA)


@pytest.mark.parametrize("name", DRAWINGS)
def test_a_drawing_is_as_it_was_looked_at(name):
    now, before = reduced(DRAWINGS[name]()), cv2.imread(str(REFERENCE / f"{name}.png"))[..., ::-1]
    assert now.shape == before.shape
    differs = np.abs(now.astype(int) - before).max(axis=-1)
    rows, columns = np.nonzero(differs > MOST)
    places = [(int(x), int(y)) for x, y in zip(BLOCK * columns, BLOCK * rows, strict=True)]
    assert not places, f"it differs at (column, row) {places[:5]}"


def plan_svg(theme):
    """The plan as SVG, with all names."""
    shapes = [*world_shapes(world("everything")), *PATHS]
    drawing = SvgPlan(bounds_of(shapes), ratio=50, theme=theme)
    drawing.draw(shapes)
    drawing.name(world_words(world("everything")))
    return drawing.data().decode()


NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e-?\d+)?")


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_a_plan_in_svg_is_as_it_was_looked_at(theme):
    now, before = plan_svg(theme), (REFERENCE / f"plan-{theme}.svg").read_text()
    assert NUMBER.sub("0", now) == NUMBER.sub("0", before)
    numbers = [np.array([float(each) for each in NUMBER.findall(text)]) for text in (now, before)]
    np.testing.assert_allclose(*numbers, atol=1e-3)


if __name__ == "__main__":
    for mode in ("light", "dark"):
        (REFERENCE / f"plan-{mode}.svg").write_text(plan_svg(mode))
    REFERENCE.mkdir(exist_ok=True)
    for each in sys.argv[1:] or DRAWINGS:
        cv2.imwrite(str(REFERENCE / f"{each}.png"), reduced(DRAWINGS[each]())[..., ::-1])
