"""Functions of MATLAB that draw over a whole figure, or behind a root locus, by name."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.patches import Ellipse, FancyArrowPatch, Patch, Rectangle

from mjsim.toolbox.calls import FigureCall
from mjsim.toolbox.draw import Drawing, ScriptFigures
from mjsim.toolbox.marks import is_text, math_text, properties_of

ARROWS = {"line": "-", "arrow": "-|>", "textarrow": "-|>", "doublearrow": "<|-|>"}
DAMPING_RATIOS = (0.2, 0.4, 0.6, 0.8, 0.9)
GRID: dict[str, Any] = {"linestyle": ":", "color": "#999999", "lw": 0.8, "zorder": 0.5}


def _annotation(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
    """Draw an arrow, a line, a box or an ellipse in fractions of the figure, with its text."""
    kind, *rest = call.arguments
    data = [np.ravel(each) for each in rest if isinstance(each, np.ndarray) and np.size(each) > 1][:2]
    words = rest[next((k for k, each in enumerate(rest) if is_text(each)), len(rest)) :]
    given, figure = properties_of(words), drawn.figure(call.figure)
    named = {str(key).lower(): value for key, value in zip(words[::2], words[1::2], strict=False)}
    text = named.get("string", "")
    text = math_text("\n".join(map(str, text)) if isinstance(text, list) else str(text))
    color = given.get("edgecolor") or given.get("color") or "black"
    style: dict[str, Any] = {"transform": figure.transFigure, "linewidth": given.get("linewidth", 0.8)}
    letters = {key: given[key] for key in ("fontsize", "color", "fontweight", "rotation") if given.get(key)}
    if kind in ARROWS:
        (x0, x1), (y0, y1) = (each[:2] for each in data)
        artist: Patch = FancyArrowPatch(
            (x0, y0), (x1, y1), arrowstyle=ARROWS[kind], mutation_scale=12, color=color, **style
        )
        if text:
            figure.text(x0, y0, text, ha="right" if x1 > x0 else "left", va="center", **letters)
    else:
        x, y, width, height = data[0].tolist()
        face = given.get("facecolor") or named.get("backgroundcolor") or "none"
        style |= {"facecolor": face, "edgecolor": color}
        if kind == "ellipse":
            artist = Ellipse((x + width / 2, y + height / 2), width, height, **style)
        else:
            artist = Rectangle((x, y), width, height, **style)
        if text:
            figure.text(x + 0.01, y + height - 0.01, text, va="top", **letters)
    figure.add_artist(artist)
    return [artist]


def _damping_grid(drawn: ScriptFigures, call: FigureCall) -> None:
    """Draw lines of equal damping, and circles of equal natural frequency, behind what the axes show."""
    drawn.after_all(call.figure, lambda axes: _damping_lines(axes))


def _damping_lines(axes: Any) -> None:
    limits = axes.get_xlim(), axes.get_ylim()
    reach = float(np.abs(limits).max())
    turn = np.linspace(np.pi / 2, 1.5 * np.pi, 90)
    for damping in DAMPING_RATIOS:
        for side in (1.0, -1.0):
            axes.plot([0.0, -2 * reach * damping], [0.0, 2 * reach * side * np.sqrt(1 - damping**2)], **GRID)
    for radius in np.linspace(0.0, reach, 5)[1:]:
        axes.plot(radius * np.cos(turn), radius * np.sin(turn), **GRID)
    axes.set(xlim=limits[0], ylim=limits[1])


def _sampled_grid(drawn: ScriptFigures, call: FigureCall) -> None:
    """Draw the unit circle, and lines of equal damping within it."""
    drawn.after_all(call.figure, lambda axes: _sampled_lines(axes))


def _sampled_lines(axes: Any) -> None:
    limits, turn = (axes.get_xlim(), axes.get_ylim()), np.linspace(0.0, np.pi, 90)
    for damping in (0.0, *DAMPING_RATIOS):
        curve = np.exp((-damping / np.sqrt(1 - damping**2) + 1j) * turn)
        for side in (1.0, -1.0):
            axes.plot(curve.real, side * curve.imag, **GRID | ({} if damping else {"linestyle": "-"}))
    axes.set(xlim=limits[0], ylim=limits[1])


ANNOTATION_FUNCTIONS: Mapping[str, Drawing] = {
    "annotation": _annotation,
    "sgrid": _damping_grid,
    "zgrid": _sampled_grid,
}
"""Functions that draw, by the names of their calls."""
