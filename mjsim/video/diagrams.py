"""Sheets and films of kinematic diagrams: each mechanism of a world in a panel, seen from the most useful direction."""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from mjsim.geometry import Array
from mjsim.interface import Picture
from mjsim.video.diagram_drawing import body_outlines, curves, distances, draw_mechanism, joint_words, posed
from mjsim.video.ink import INK, MUTED, PAPER, SEMIBOLD, Letters
from mjsim.video.paper import Paper, px
from mjsim.video.picture_layout import HEIGHT, WIDTH
from mjsim.video.placed_names import write_words
from mjsim.video.plan_parts import draw_scale_bar
from mjsim.video.plan_view import PlanView
from mjsim.world import Mechanism, World

HEAD, PANEL_MARGINS = 6.5, 7.0
"""Margin above a diagram for its name, and around it [mm]."""
MIN_PANEL_WIDTH = 60.0
"""Minimum width of a panel on a sheet [mm]."""
MAX_PANEL_WIDTH = 100.0
"""Maximum width of a panel on a sheet [mm]."""
MIN_PARALLEL_SHARE = 0.98
"""Minimum fraction of parallel rotation axes in a planar mechanism."""
OBLIQUE = (math.radians(-60.0), math.radians(25.0))
"""Azimuth and elevation from which spatial mechanisms are seen [rad]."""
MAX_SLIDE_COSINE = 0.1
"""Maximum cosine between the slides of a planar mechanism and its normal."""
MIN_VERTICAL_COSINE = 0.9
"""An axis with a larger cosine to the vertical counts as vertical."""
POSTURE_COUNT = 48
"""Number of postures of a motion to which a diagram is scaled."""


def best_look(mechanism: Mechanism) -> Array:
    """Return drawing_from_world for a mechanism, shape (3, 4) [m]: along its axes if they are parallel."""
    placed = mechanism.assembly.linkage.place(mechanism.assembly.start)
    turn = mechanism.world_from_ground[:3, :3]
    own = np.concatenate([np.array(mechanism.assembly.columns[joint.name], dtype=int) for joint in mechanism.joints])
    turns, slides = (placed.axes[own[placed.slides[own] == slides]] @ turn.T for slides in (False, True))
    toward = np.array([0.0, -1.0, 0.0])
    if len(turns):
        sizes, directions = np.linalg.eigh(turns.T @ turns)
        if sizes[-1] > MIN_PARALLEL_SHARE * len(turns) and np.all(
            np.abs(slides @ directions[:, -1]) < MAX_SLIDE_COSINE
        ):
            return view_along(directions[:, -1])
        azimuth, elevation = OBLIQUE
        toward = np.array([math.cos(azimuth), math.sin(azimuth), math.tan(elevation)])
    return view_along(toward / np.linalg.norm(toward))


def view_along(toward: Array) -> Array:
    """Return drawing_from_world for a direction towards the viewer, shape (3, 4) [m]: x to the right, or z up."""
    if abs(toward[2]) > MIN_VERTICAL_COSINE:
        return np.eye(4)[:3]
    if toward[1] > 1e-9 or (abs(toward[1]) <= 1e-9 and toward[0] < 0):
        toward = -toward
    right = np.cross([0.0, 0.0, 1.0], toward)
    right /= np.linalg.norm(right)
    return np.column_stack([np.array([right, np.cross(toward, right), toward]), np.zeros(3)])


class Diagram:
    """One mechanism in its panel, scaled to fit all given postures."""

    def __init__(self, mechanism: Mechanism, postures: Sequence[Array], *, width: int, height: int) -> None:
        """Choose the viewing direction and the scale.

        Args:
            mechanism: The mechanism.
            postures: Joint values, shape (values,) each [rad, m].
            width: Width of the panel [px].
            height: Height of the panel [px].
        """
        self.mechanism, self._view_matrix = mechanism, best_look(mechanism)
        self._width, self._height = width, height
        margin, head = round(px(PANEL_MARGINS)), round(px(HEAD))
        view = PlanView.fit(_bounds(mechanism, postures, self._view_matrix), width, height - head, margin=margin)
        self._view = PlanView(view.left, view.top + head / view.scale, view.scale, width, height)

    def draw(self, letters: Letters, values: Array, *, names: bool) -> Picture:
        """Return the panel for given joint values, RGB, shape (height, width, 3)."""
        image = np.full((self._height, self._width, 3), PAPER, np.uint8)
        drawing, drawn = Paper(image, self._view, letters), posed(self.mechanism, values, self._view_matrix)
        draw_mechanism(drawing, drawn)
        if names:
            write_words(drawing, joint_words(drawn))
        letters.write(image, self.mechanism.name, (px(2.0), px(4.6)), round(px(3.2)), INK, weight=SEMIBOLD)
        draw_scale_bar(image, self._view.scale, letters, (self._width - round(px(2.0)), self._height - round(px(2.0))))
        self._draw_triad(drawing)
        return image

    def _draw_triad(self, drawing: Paper) -> None:
        """Draw the directions of the world's x, y and z in the lower left corner."""
        foot = self._view.world([px(4.0), self._height - px(4.0)])
        for number, name in enumerate("xyz"):
            axis = self._view_matrix[:2, number]
            if np.hypot(*axis) > 0.2:
                tip = foot + axis * drawing.metres(5.0)
                drawing.arrow([foot, tip], MUTED, 0.2)
                at = self._view.pixels(tip + axis / np.hypot(*axis) * drawing.metres(1.6))
                drawing.letters.write(drawing.image, name, (at[0], at[1] + px(0.7)), round(px(2.0)), MUTED, align=0.5)


def _bounds(mechanism: Mechanism, postures: Sequence[Array], drawing_from_world: Array) -> Array:
    """Return the bounding box of all postures in the drawing, shape (2, 2) [m]."""
    drawn = [posed(mechanism, values, drawing_from_world) for values in postures]
    parts = [outline for each in drawn for _, outline in body_outlines(each)]
    parts += [curve for each in drawn for curve in curves(each)]
    parts += [np.array([each.joint(joint)[:2]]) for each in drawn for joint in mechanism.joints]
    parts += [ends for each in drawn for led in (False, True) for ends in distances(each, led=led)]
    points = np.concatenate(parts)
    return np.stack([points.min(axis=0), points.max(axis=0)])


def diagrams_page(world: World, width: int, *, names: bool) -> Picture:
    """Return diagrams of all mechanisms of a world in their initial posture, RGB, in rows of a width [px]."""
    columns = max(1, min(len(world.mechanisms), int(width / px(MIN_PANEL_WIDTH))))
    cell, letters, rows = min(width // columns, round(px(MAX_PANEL_WIDTH))), Letters(), []
    for first in range(0, len(world.mechanisms), columns):
        group = world.mechanisms[first : first + columns]
        shapes = [np.ptp(_bounds(item, [item.assembly.start], best_look(item)), axis=0) for item in group]
        height = round(cell * max(float(np.clip(tall / max(wide, 1e-9), 0.35, 1.0)) for wide, tall in shapes))
        row = np.full((height + round(px(HEAD)), width, 3), PAPER, np.uint8)
        for place, item in enumerate(group):
            panel = Diagram(item, [item.assembly.start], width=cell, height=len(row))
            row[:, place * cell : (place + 1) * cell] = panel.draw(letters, item.assembly.start, names=names)
        rows.append(row)
    return np.concatenate(rows)


def some_of(positions: Array, count: int) -> Array:
    """Return at most `count` evenly spaced rows without NaN; positions have shape (N, values)."""
    known = positions[np.isfinite(positions).all(axis=1)]
    rows = np.linspace(0, max(len(known) - 1, 0), min(count, len(known))).astype(int)
    return np.asarray(known[np.unique(rows)])


class DiagramFrame:
    """Diagrams of all mechanisms of a moving world, 1280 x 720."""

    def __init__(self, world: World, motions: Mapping[str, Array]) -> None:
        """Choose scales that fit the whole motion.

        Args:
            world: The world.
            motions: Positions of the joints of each mechanism over time, shape (N, values) [rad, m].
        """
        self._letters, count = Letters(), len(world.mechanisms)
        self._columns = math.ceil(math.sqrt(count))
        size = WIDTH // self._columns, HEIGHT // math.ceil(count / self._columns)
        self._panels = []
        for item in world.mechanisms:
            postures = [item.assembly.start, *some_of(motions[item.name], POSTURE_COUNT)]
            self._panels.append(Diagram(item, postures, width=size[0], height=size[1]))
        self._page = np.full((HEIGHT, WIDTH, 3), PAPER, np.uint8)

    def draw(self, time: float, values: Mapping[str, Array]) -> Picture:
        """Return the picture at a time, RGB, shape (720, 1280, 3); every call returns the same array.

        Args:
            time: Since the start of the run [s].
            values: Joint values of each mechanism, shape (values,) [rad, m].
        """
        for number, panel in enumerate(self._panels):
            picture = panel.draw(self._letters, values[panel.mechanism.name], names=False)
            row, column = divmod(number, self._columns)
            height, width = picture.shape[:2]
            self._page[row * height : (row + 1) * height, column * width : (column + 1) * width] = picture
        strip = self._page[: round(px(HEAD)), WIDTH - 100 :]
        strip[:] = PAPER
        self._letters.write(strip, f"{time:.1f} s", (92, 24), 16, INK, align=1.0)
        return self._page
