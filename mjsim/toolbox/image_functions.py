"""Functions of MATLAB that draw images, histograms, shares and shapes, and that arrange axes, by name."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.patches import Ellipse, FancyBboxPatch, Patch

from mjsim.geometry import Array
from mjsim.toolbox.calls import FigureCall
from mjsim.toolbox.draw import Drawing, ScriptFigures
from mjsim.toolbox.marks import data_of, properties_of, words_of
from mjsim.toolbox.panes import ORDER
from mjsim.toolbox.properties import set_ticks


def _arrays(call: FigureCall) -> list[Array]:
    return [each for each in call.arguments if isinstance(each, np.ndarray)]


def _image(kind: str) -> Drawing:
    """Return a function that draws a matrix: 'image' 0 to 255, 'scaled' by its range, 'shown' in grey without axes."""

    def drawing(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
        data = _arrays(call)
        matrix, corners = (data[2], data[:2]) if len(data) > 2 else (data[0], [])
        pane = drawn.cleared(call.figure)
        height, width = matrix.shape[:2]
        x, y = ((np.ravel(each)[0], np.ravel(each)[-1]) for each in corners) if corners else ((1, width), (1, height))
        half = (x[1] - x[0]) / max(width - 1, 1) / 2, (y[1] - y[0]) / max(height - 1, 1) / 2
        edges = (x[0] - half[0], x[1] + half[0], y[1] + half[1], y[0] - half[1])
        grey = kind == "shown"
        top = 255.0 if float(np.nanmax(matrix, initial=0.0)) > 1.0 else 1.0
        seen = matrix / top if matrix.ndim == 3 else matrix
        words: dict[str, Any] = (
            {"cmap": "gray", "vmin": 0.0, "vmax": top} if grey else {"cmap": drawn.map_of(call.figure)}
        )
        limits = data[1].ravel().tolist() if len(data) == 2 and data[1].size == 2 else []
        words |= {"vmin": limits[0], "vmax": limits[1]} if len(limits) else {}
        artist = pane.axes.imshow(seen, extent=edges, aspect="equal" if grey else "auto", **words)
        if grey:
            pane.axes.set_axis_off()
        return [artist]

    return drawing


def _cells(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
    data, pane = _arrays(call)[:3], drawn.cleared(call.figure)
    return [pane.axes.pcolormesh(*data, cmap=drawn.map_of(call.figure), shading="auto")]


def _histogram(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
    data, pane = data_of(call), drawn.cleared(call.figure)
    values = data[0][np.isfinite(data[0])]
    words, given = words_of(call)
    density = given.get("normalization") == "pdf"
    bins: Any = 10 if len(data) < 2 else int(data[1].ravel()[0]) if data[1].size == 1 else data[1].ravel()
    weights = None
    if call.name == "hist":
        if np.size(bins) > 1:
            # hist has the centres of its bins, whose ends count all that is beyond them.
            inner = (bins[1:] + bins[:-1]) / 2
            ends = bins[0] - (inner[0] - bins[0]), bins[-1] + (bins[-1] - inner[-1])
            values, bins = np.clip(values, *ends), np.concatenate([[ends[0]], inner, [ends[1]]])
        if len(data) > 2 and data[2].size == 1:
            weights = np.full(len(values), float(data[2].ravel()[0]) / max(len(values), 1))
    elif given.get("normalization") == "probability":
        weights = np.full(len(values), 1.0 / max(len(values), 1))
    color = words.get("facecolor") or words.get("color") or ORDER[pane.lines % len(ORDER)]
    artist = pane.axes.hist(values, bins=bins, density=density, weights=weights, color=color, edgecolor="black")[2]
    pane.lines += 1
    pane.labelled.append(artist)
    return [artist]


def _pie(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
    values = np.ravel(_arrays(call)[0])
    names = next((each for each in call.arguments if isinstance(each, list)), None)
    share = values / values.sum() if values.sum() > 1.0 else values
    labels = names or [f"{100 * each:.0f}%" for each in share]
    drawn.cleared(call.figure).axes.pie(share, labels=labels, colors=ORDER, startangle=90)
    return []


def _rectangle(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
    """Draw a rectangle, or an ellipse with a curvature of 1."""
    given = {str(key).lower(): value for key, value in zip(call.arguments[::2], call.arguments[1::2], strict=False)}
    x, y, width, height = np.ravel(given["position"]).tolist()
    curvature = np.ravel(given.get("curvature", 0.0))
    round_ = float(curvature.max()) * min(width, height) / 2.0
    colors = {"facecolor": "none", "edgecolor": "black", **properties_of(call.arguments)}
    style = f"round,pad=0,rounding_size={round_}" if round_ else "square,pad=0"
    axes = drawn.pane(call.figure).axes
    patch: Patch = FancyBboxPatch((x, y), width, height, boxstyle=style, **colors)
    if curvature.size > 1 and curvature.min() >= 1.0:
        patch = Ellipse((x + width / 2, y + height / 2), width, height, **colors)
    axes.add_patch(patch)
    axes.update_datalim([(x, y), (x + width, y + height)])
    axes.autoscale_view()
    return [patch]


def _ticks(method: str) -> Drawing:
    def setting(drawn: ScriptFigures, call: FigureCall) -> None:
        axes, value = drawn.pane(call.figure).axes, call.arguments[0] if call.arguments else None
        if isinstance(value, np.ndarray | list) and hasattr(axes, method):
            set_ticks(axes, method, value if isinstance(value, list) else np.ravel(value).tolist())

    return setting


def _turned(axis: str) -> Drawing:
    def turning(drawn: ScriptFigures, call: FigureCall) -> None:
        drawn.pane(call.figure).axes.tick_params(axis=axis, rotation=float(np.ravel(call.arguments[0])[0]))

    return turning


def _colors(drawn: ScriptFigures, call: FigureCall) -> None:
    limits = np.ravel(_arrays(call)[0]).tolist() if _arrays(call) else []
    for artist in (*drawn.pane(call.figure).axes.collections, *drawn.pane(call.figure).axes.images):
        if len(limits) == 2:
            artist.set_clim(*limits)


def _colormap(drawn: ScriptFigures, call: FigureCall) -> None:
    drawn.set_map(call.figure, call.arguments[-1] if call.arguments else "viridis")


IMAGE_FUNCTIONS: Mapping[str, Drawing] = {
    "imshow": _image("shown"),
    "image": _image("image"),
    "imagesc": _image("scaled"),
    "pcolor": _cells,
    "hist": _histogram,
    "histogram": _histogram,
    "pie": _pie,
    "rectangle": _rectangle,
    "xticks": _ticks("set_xticks"),
    "yticks": _ticks("set_yticks"),
    "xticklabels": _ticks("set_xticklabels"),
    "yticklabels": _ticks("set_yticklabels"),
    "xtickangle": _turned("x"),
    "ytickangle": _turned("y"),
    "caxis": _colors,
    "clim": _colors,
    "colormap": _colormap,
    "yyaxis": ScriptFigures.choose_side,
    "tiledlayout": ScriptFigures.tile,
    "nexttile": ScriptFigures.next_tile,
}
"""Functions that draw, by the names of their calls."""
