"""Arrangement of the parts of a composed picture, depending on the shapes of the world and of the onboard picture."""

from dataclasses import dataclass

from mjsim.geometry import Array

WIDTH, HEIGHT = 1280, 720
MARGIN, GAP, HEAD = 16, 12, 48
CHART_HEIGHT = 150
"""Height of the chart below the plan [px]."""
COLUMN_WIDTH = 480
"""Width of the right column [px]: close-up above, onboard picture below."""
MAX_ASPECT, MIN_ASPECT = 2.4, 0.75
"""Worlds wider than the first or narrower than the second have their own arrangements (width by height)."""


@dataclass(frozen=True, slots=True)
class Pane:
    """A part of the picture [px]."""

    x: int
    y: int
    width: int
    height: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Layout:
    """The parts of a composed picture below its header."""

    plan: Pane
    close_up: Pane
    chart: Pane
    onboard: Pane | None
    """None for a robot without camera."""


def arrange(bounds: Array, *, camera: float | None) -> Layout:
    """Return the position of all parts.

    Args:
        bounds: Bounds of the world, minimum and maximum of (x, y), shape (2, 2) [m].
        camera: Ratio of width to height of the onboard picture; None without one.
    """
    width, height = bounds[1] - bounds[0]
    shape = float(width / height)
    if shape > MAX_ASPECT:
        return _wide(shape, camera)
    return _tall(shape, camera) if shape < MIN_ASPECT else _usual(camera)


def _usual(camera: float | None) -> Layout:
    """Plan above the chart on the left, close-up above the onboard picture on the right."""
    left = WIDTH - 2 * MARGIN - GAP - COLUMN_WIDTH
    x, bottom = MARGIN + left + GAP, HEIGHT - MARGIN
    rows = min(round(COLUMN_WIDTH / camera), 400) if camera else 0
    return Layout(
        plan=Pane(MARGIN, HEAD, left, bottom - HEAD - GAP - CHART_HEIGHT),
        chart=Pane(MARGIN, bottom - CHART_HEIGHT, left, CHART_HEIGHT),
        close_up=Pane(x, HEAD, COLUMN_WIDTH, bottom - HEAD - (rows + GAP if rows else 0)),
        onboard=Pane(x, bottom - rows, COLUMN_WIDTH, rows) if rows else None,
    )


def _wide(shape: float, camera: float | None) -> Layout:
    """Plan over the full width, everything else in a row below."""
    across = WIDTH - 2 * MARGIN
    plan = Pane(MARGIN, HEAD, across, min(max(round(across / shape) + 20, 140), 320))
    y = HEAD + plan.height + GAP
    rows = HEIGHT - MARGIN - y
    columns = min(round(rows * camera), 560) if camera else 0
    rest = across - (columns + GAP if columns else 0)
    left = (rest - GAP) // 2
    return Layout(
        plan=plan,
        chart=Pane(MARGIN, y, left, rows),
        close_up=Pane(MARGIN + left + GAP, y, rest - GAP - left, rows),
        onboard=Pane(MARGIN + across - columns, y, columns, rows) if columns else None,
    )


def _tall(shape: float, camera: float | None) -> Layout:
    """Plan from top to bottom on the left, close-up and onboard picture side by side above the chart."""
    rows = HEIGHT - MARGIN - HEAD
    plan = Pane(MARGIN, HEAD, min(max(round(rows * shape) + 20, 200), 460), rows)
    x = MARGIN + plan.width + GAP
    across = WIDTH - MARGIN - x
    columns = round(0.55 * across) if camera else 0
    above = min(round(columns / camera), rows - GAP - CHART_HEIGHT) if camera else rows - GAP - CHART_HEIGHT
    return Layout(
        plan=plan,
        chart=Pane(x, HEAD + above + GAP, across, rows - GAP - above),
        close_up=Pane(x, HEAD, across - (columns + GAP if columns else 0), above),
        onboard=Pane(WIDTH - MARGIN - columns, HEAD, columns, above) if columns else None,
    )
