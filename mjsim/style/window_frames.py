"""Frames of doorways and windows, and what is seen through a window."""

from collections.abc import Callable, Iterator

from mjsim.style.atlas_faces import Quad
from mjsim.style.hanging import FRAME_WIDTH, Hanging, overlap
from mjsim.style.recipes import RoomStyle, WallItem
from mjsim.style.sides import BEACON_MARGIN, Rectangle, Side, WallOpening

FRAME_THICKNESS = 0.012
"""Thickness of a frame on the wall [m]."""
BAR_WIDTH = 0.05
"""Width of the bars of a window [m]."""
COVERED_SHARE = 0.3
"""Share of a window that blinds or curtains cover."""
RADIATOR = WallItem("radiator", 1.0, 0.55, 0.14, 1.0, 0.06, "white", 99)
MIN_SILL = 0.75
"""Lowest sill above a radiator [m]."""
SWITCH = WallItem("switch", 0.08, 0.08, 1.05, 1.0, 0.01, "white", 99)
SIGN = WallItem("door_sign", 0.21, 0.15, 1.45, 1.0, 0.008, "gray", 99)
EXIT = WallItem("exit", 0.4, 0.18, 2.2, 1.0, 0.03, "green", 99)


def opening_faces(
    side: Side, hanging: Hanging, style: RoomStyle, *, view: Callable[[WallOpening], bool]
) -> Iterator[Quad]:
    """Yield frames, windows, and what belongs beside doors, on one side.

    Args:
        side: The side.
        hanging: Its things.
        style: The style.
        view: Whether a window shows the view, as nothing is beyond it.
    """
    for hole in side.holes:
        if hole.opening.sill >= side.height:
            continue
        yield from _casing(side, hole, style.frame)
        if hole.opening.sill > 0.0:
            if view(hole):
                yield from _window(side, hole, hanging, style)
            if hole.opening.sill >= MIN_SILL:
                yield from hanging.put((hole.left + hole.right - RADIATOR.width) / 2, RADIATOR)
        else:
            yield from hanging.put(hole.right + FRAME_WIDTH + 0.1, SWITCH)
            yield from hanging.put(hole.left - FRAME_WIDTH - 0.12 - SIGN.width, SIGN)
            if side.length > 6.0:
                yield from hanging.put((hole.left + hole.right - EXIT.width) / 2, EXIT)


def _casing(side: Side, hole: WallOpening, part: str) -> Iterator[Quad]:
    """Yield the bars around an opening; a bar that would touch a beacon or its margin is left out."""
    low, high = hole.opening.sill, min(hole.opening.head, side.height)
    bars: list[Rectangle] = [
        (hole.left - FRAME_WIDTH, hole.left, low, high + FRAME_WIDTH),
        (hole.right, hole.right + FRAME_WIDTH, low, high + FRAME_WIDTH),
        (hole.left, hole.right, high, high + FRAME_WIDTH),
    ]
    if low > 0.0:
        bars.append((hole.left - FRAME_WIDTH, hole.right + FRAME_WIDTH, low - 0.04, low))
    for bar in bars:
        within = bar[0] >= 0.0 and bar[1] <= side.length and bar[3] <= side.height
        if within and not any(overlap(bar, _bare(beacon)) for beacon in side.beacons):
            proud = FRAME_THICKNESS if bar[2] >= low else 4 * FRAME_THICKNESS
            yield from side.frame.block(bar[:2], (0.0, proud), bar[2:], part, part)


def _bare(beacon: Rectangle) -> Rectangle:
    """Return the rectangle of a beacon with a narrow margin: a door's frame is even, and cannot be elsewhere."""
    less = BEACON_MARGIN - 2 * FRAME_THICKNESS
    return beacon[0] + less, beacon[1] - less, beacon[2] + less, beacon[3] - less


def _window(side: Side, hole: WallOpening, hanging: Hanging, style: RoomStyle) -> Iterator[Quad]:
    """Yield the bars, the view and the cover of a window, within the thickness of its wall."""
    frame, back = side.frame, -0.7 * hole.thickness
    left, right, low, high = hole.left, hole.right, hole.opening.sill, min(hole.opening.head, side.height)
    middle, width = (left + right) / 2, right - left
    view = hanging.one_of(style.view)
    yield frame.sheet((left, right), (low, high), back - 0.01, view)
    for across in (
        (left, left + BAR_WIDTH),
        (middle - BAR_WIDTH / 2, middle + BAR_WIDTH / 2),
        (right - BAR_WIDTH, right),
    ):
        yield from frame.block(across, (back - 0.01, back + 0.03), (low, high), "white", "gray")
    for up in ((low, low + BAR_WIDTH), (high - BAR_WIDTH, high)):
        yield from frame.block((left, right), (back - 0.01, back + 0.03), up, "white", "gray")
    if style.cover == "blinds":
        share = COVERED_SHARE * hanging.rng.uniform(0.3, 2.0)
        yield frame.sheet((left, right), (high - share * (high - low), high), back + 0.05, "blinds/1")
    else:
        for across in ((left, left + COVERED_SHARE / 2 * width), (right - COVERED_SHARE / 2 * width, right)):
            yield frame.sheet(across, (low, high), -0.01, "curtain/1")
