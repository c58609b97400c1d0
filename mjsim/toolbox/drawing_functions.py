"""Functions of MATLAB that draw, by name."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.cm import ScalarMappable

from mjsim.geometry import Array
from mjsim.toolbox.annotation_functions import ANNOTATION_FUNCTIONS
from mjsim.toolbox.arm_functions import ARM_FUNCTIONS
from mjsim.toolbox.bar_functions import BAR_FUNCTIONS
from mjsim.toolbox.calls import FigureCall
from mjsim.toolbox.draw import Drawing, ScriptFigures
from mjsim.toolbox.film_functions import FILM_FUNCTIONS
from mjsim.toolbox.image_functions import IMAGE_FUNCTIONS
from mjsim.toolbox.marks import as_columns, data_of, is_text, line_format, properties_of, words_of
from mjsim.toolbox.panes import ORDER
from mjsim.toolbox.properties import DATA, set_on
from mjsim.toolbox.solid_functions import SOLID_FUNCTIONS
from mjsim.toolbox.text_functions import TEXT_FUNCTIONS


def _groups(arguments: Sequence[Any], dimensions: int) -> tuple[list[tuple[list[Array], dict[str, Any]]], list[Any]]:
    """Return the data of each group of lines with its format, and the pairs of properties at the end."""
    rest = list(arguments)
    groups: list[tuple[list[Array], dict[str, Any]]] = []
    while rest and not is_text(rest[0]):
        data: list[Array] = []
        while rest and not is_text(rest[0]) and len(data) < dimensions:
            data.append(as_columns(rest.pop(0)))
        if dimensions == 2 and len(data) == 1:
            data.insert(0, np.arange(1.0, len(data[0]) + 1).reshape(-1, 1))
        style = line_format(rest[0]) if rest and is_text(rest[0]) else None
        if style is not None:
            rest.pop(0)
        groups.append((data, style or {}))
    return groups, rest


def _columns(data: Sequence[Array]) -> list[list[Array]]:
    """Return the lines of a group: each column of its matrices, transposed where only that fits."""
    length = len(data[0])
    fitted = [each if len(each) == length or each.shape[1] != length else each.T for each in data]
    count = max(each.shape[1] for each in fitted)
    return [[each[:, min(k, each.shape[1] - 1)] for each in fitted] for k in range(count)]


def _lines(draw: Callable[[Any], Callable[..., Any]], dimensions: int = 2) -> Drawing:
    """Return a function that draws lines with a method of axes."""

    def drawing(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
        pane = drawn.cleared(call.figure, solid=dimensions == 3)
        groups, words = _groups(call.arguments, dimensions)
        given, made = properties_of(words), []
        hidden = any(pair == ("HandleVisibility", "off") for pair in pairwise(map(str, words)))
        for data, style in groups:
            for column in _columns(data):
                keywords = {"color": ORDER[pane.lines % len(ORDER)], **style, **given}
                artists = draw(pane.axes)(*column, **{key: v for key, v in keywords.items() if v is not None})
                made.append(artists[0] if isinstance(artists, list) else artists)
                pane.lines += 1
        if not hidden:
            pane.labelled += made
        return made

    return drawing


def _line(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
    """Draw a line into axes without clearing them."""
    given = data_of(call)
    data = given or [np.zeros(0), np.zeros(0)]
    pane = drawn.pane(call.figure, solid=len(data) == 3)
    keywords = {"color": ORDER[0], **properties_of(call.arguments[len(given) :])}
    made = list(pane.axes.plot(*(np.ravel(each) for each in data), **keywords))
    pane.labelled += made
    return made


def _more_points(drawn: ScriptFigures, call: FigureCall) -> None:
    """Add points to a line."""
    handle, *points = data_of(call)
    for artist in drawn.artists(float(np.ravel(handle)[0])):
        kept = artist.get_data_3d() if hasattr(artist, "get_data_3d") else artist.get_data()
        if len(points) == 3 and len(kept) == 2:
            # The first points show whether the line is 3-D.
            artist.remove()
            pane = drawn.pane(call.figure, solid=True)
            (line,) = pane.axes.plot([], [], [], color=artist.get_color())
            drawn.rename(float(np.ravel(handle)[0]), line)
            artist, kept = line, ([], [], [])
        made = [np.append(old, np.ravel(new)) for old, new in zip(kept, points, strict=True)]
        set_on(artist, [word for name, values in zip(DATA, made, strict=False) for word in (name, values)])


def _stems(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
    """Draw lines from a base line to points, a colour for each column."""
    data, (words, given) = [as_columns(each) for each in data_of(call)[:2]], words_of(call)
    x, y = data if len(data) == 2 else (np.arange(1.0, len(data[0]) + 1).reshape(-1, 1), data[0])
    pane, made = drawn.cleared(call.figure), []
    filled = "filled" in filter(is_text, call.arguments) or "markerfacecolor" in given
    for column in _columns([x, y]):
        color = words.get("color") or ORDER[pane.lines % len(ORDER)]
        parts = pane.axes.stem(*column, linefmt=words.get("linestyle", "-").replace("none", "-"), basefmt="k-")
        parts.stemlines.set(color=color, linewidth=words.get("linewidth", 1.2))
        parts.baseline.set_linewidth(0.8)
        face = words.get("markerfacecolor") or (color if filled else "white")
        parts.markerline.set(color=color, markerfacecolor=face, marker=words.get("marker", "o"))
        made.append(parts.markerline)
        pane.lines += 1
    pane.labelled += made
    return made


def _pattern(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
    """Draw the nonzero elements of a matrix."""
    axes = drawn.cleared(call.figure).axes
    axes.spy(data_of(call)[0], markersize=4)
    return [axes]


def _fill(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
    """Draw polygons, a column each, or faces of vertices; a third row of three numbers is their colour."""
    data, (words, given) = data_of(call), words_of(call)
    if len(data) == 4 or np.shape(given.get("vertices", 0.0))[-1:] == (3,) or "zdata" in given:
        return list(SOLID_FUNCTIONS["fill3"](drawn, call))
    colors = {"color": ORDER[0], **words}
    if len(data) == 3 and data[2].size == 3 and data[0].size != 3:
        colors["color"] = np.clip(np.ravel(data[2]), 0.0, 1.0).tolist()
    if "facecolor" in colors:
        colors["edgecolor"] = colors.get("edgecolor", "black")
        del colors["color"]
    if "vertices" in given and "faces" in given:
        faces = np.atleast_2d(given["faces"]).astype(int) - 1
        outlines = [[given["vertices"][face, 0], given["vertices"][face, 1]] for face in faces]
    else:
        outlines = _columns([as_columns(each) for each in data[:2]])
    pane = drawn.pane(call.figure)
    made = [artist for outline in outlines for artist in pane.axes.fill(*outline, **colors)]
    pane.labelled += made[:1]
    return made


def _scatter(dimensions: int) -> Drawing:
    def drawing(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
        """Draw points; after their coordinates come their areas in square points, and their colours."""
        data = [np.ravel(each) if each.shape[-1] != 3 else each for each in data_of(call)]
        pane, words = drawn.cleared(call.figure, solid=dimensions == 3), call.arguments[len(data) :]
        sizes, colors = (data[k] if len(data) > k and data[k].size else None for k in (dimensions, dimensions + 1))
        style = next((each for each in map(line_format, filter(is_text, words)) if each), {})
        chosen = style.get("color", ORDER[pane.lines % len(ORDER)]) if colors is None else colors
        points = [np.ravel(each) for each in data[:dimensions]]
        artist = pane.axes.scatter(*points, s=36 if sizes is None else sizes, c=chosen, marker=style.get("marker", "o"))
        if "filled" not in words and style.get("marker", "o") not in "+x.*":
            edges = chosen if isinstance(chosen, str) else artist.get_facecolor()
            if artist.get_array() is not None:
                edges = artist.to_rgba(artist.get_array())
                artist.mjsim_scale = ScalarMappable(artist.norm, artist.cmap)
                artist.set_array(None)
            artist.set_facecolor("none")
            artist.set_edgecolor(edges)
        pane.lines += 1
        pane.labelled.append(artist)
        return [artist]

    return drawing


def _polar(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
    """Draw a curve of angles and radii, with a grid of circles."""
    angle, radius = (np.ravel(each) for each in call.arguments[:2])
    pane, (words, _) = drawn.cleared(call.figure), words_of(call)
    pane.axes.set_aspect("equal")
    turn = np.linspace(0, 2 * np.pi, 200)
    for size in np.linspace(0, float(np.abs(radius).max()), 5)[1:]:
        pane.axes.plot(size * np.cos(turn), size * np.sin(turn), ":", color="#999999", lw=0.8)
    return list(pane.axes.plot(radius * np.cos(angle), radius * np.sin(angle), **{"color": ORDER[0], **words}))


def _hold(drawn: ScriptFigures, call: FigureCall) -> None:
    pane = drawn.pane(call.figure)
    word = call.arguments[-1] if call.arguments and isinstance(call.arguments[-1], str) else None
    pane.hold = not pane.hold if word is None else word != "off"


def _grid(drawn: ScriptFigures, call: FigureCall) -> None:
    words, axes = [each for each in call.arguments if isinstance(each, str)], drawn.pane(call.figure).axes
    if "minor" in words and axes.name != "3d":
        axes.minorticks_on()
        axes.grid(visible=True, which="minor", alpha=0.2)
        return
    axes.grid(visible="off" not in words, alpha=0.4)


def _axis(drawn: ScriptFigures, call: FigureCall) -> None:
    axes = drawn.pane(call.figure).axes
    for word in call.arguments:
        if isinstance(word, np.ndarray) and word.size >= 4:
            limits = np.ravel(word)
            for setter, pair in zip(("set_xlim", "set_ylim", "set_zlim"), limits.reshape(-1, 2), strict=False):
                _limit(axes, setter, pair)
        elif word in ("equal", "image"):
            axes.set_aspect("equal", adjustable="datalim" if axes.name != "3d" and word == "equal" else "box")
        elif word == "square" and axes.name != "3d":
            axes.set_box_aspect(1)
        elif word == "tight":
            axes.margins(0)
        elif word in ("off", "on"):
            (axes.set_axis_off if word == "off" else axes.set_axis_on)()
        elif word in ("ij", "xy") and axes.yaxis_inverted() != (word == "ij"):
            axes.invert_yaxis()
    if "tight" in filter(is_text, call.arguments) and axes.name != "3d" and axes.get_aspect() != "auto":
        axes.set_aspect("equal", adjustable="box")
    _keep_limits(axes)


def _limit(axes: Any, method: str, pair: Array) -> None:
    """Set the limits of an axis; one that is infinite stays that of the data."""
    ends = [float(end) if np.isfinite(end) else None for end in pair]
    if hasattr(axes, method) and ends != [None, None]:
        getattr(axes, method)(*ends)


def _keep_limits(axes: Any) -> None:
    """Give axes of equal scales a box of their limits, if these are fixed."""
    if axes.name != "3d" and axes.get_aspect() != "auto" and not axes.get_autoscalex_on():
        axes.set_aspect("equal", adjustable="box")


def _limits(method: str) -> Drawing:
    def limiting(drawn: ScriptFigures, call: FigureCall) -> None:
        axes = drawn.pane(call.figure).axes
        if call.arguments and isinstance(call.arguments[0], np.ndarray):
            _limit(axes, method, np.ravel(call.arguments[0])[:2])
            _keep_limits(axes)

    return limiting


def _view(drawn: ScriptFigures, call: FigureCall) -> None:
    axes = drawn.pane(call.figure).axes
    numbers = [float(each) for part in call.arguments if isinstance(part, np.ndarray) for each in np.ravel(part)]
    if axes.name == "3d" and numbers:
        azimuth, elevation = numbers if len(numbers) == 2 else ((-37.5, 30.0) if numbers == [3.0] else (0.0, 90.0))
        # MATLAB counts the azimuth from the negative y axis.
        axes.view_init(elev=elevation, azim=azimuth - 90.0)


def _figure(drawn: ScriptFigures, call: FigureCall) -> None:
    drawn.figure(call.figure)


def _choose(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
    return [drawn.pane(call.figure).axes]


def _clear(drawn: ScriptFigures, call: FigureCall) -> None:
    pane = drawn.pane(call.figure)
    pane.axes.clear()
    pane.lines, pane.labelled, pane.settings, pane.hold = pane.first, [], [], False
    drawn.motions[call.figure] = [motion for motion in drawn.motions.get(call.figure, []) if motion.pane is not pane]


FUNCTIONS: Mapping[str, Drawing] = {
    **IMAGE_FUNCTIONS,
    **BAR_FUNCTIONS,
    **SOLID_FUNCTIONS,
    **TEXT_FUNCTIONS,
    **ANNOTATION_FUNCTIONS,
    **ARM_FUNCTIONS,
    **FILM_FUNCTIONS,
    "figure": _figure,
    "subplot": ScriptFigures.subplot,
    "gca": _choose,
    "axes": ScriptFigures.add_axes,
    "clf": ScriptFigures.clear_figure,
    "cla": _clear,
    "set": ScriptFigures.set_properties,
    "print": ScriptFigures.save,
    "saveas": ScriptFigures.save,
    "exportgraphics": ScriptFigures.save,
    "plot": _lines(lambda axes: axes.plot),
    "semilogx": _lines(lambda axes: axes.semilogx),
    "semilogy": _lines(lambda axes: axes.semilogy),
    "loglog": _lines(lambda axes: axes.loglog),
    "stairs": _lines(lambda axes: lambda *data, **words: axes.step(*data, where="post", **words)),
    "stem": _stems,
    "scatter": _scatter(2),
    "plot3": _lines(lambda axes: axes.plot, 3),
    "scatter3": _scatter(3),
    "comet": _lines(lambda axes: axes.plot),
    "comet3": _lines(lambda axes: axes.plot, 3),
    "line": _line,
    "animatedline": _line,
    "addpoints": _more_points,
    "spy": _pattern,
    "daspect": lambda drawn, call: _axis(drawn, replace(call, arguments=("equal",))) if call.arguments else None,
    "newplot": _choose,
    "delete": ScriptFigures.delete,
    **dict.fromkeys(("savefig", "hgsave", "hgexport", "export_fig"), ScriptFigures.save),
    "fill": _fill,
    "patch": _fill,
    "polar": _polar,
    "polarplot": _polar,
    "hold": _hold,
    "grid": _grid,
    "axis": _axis,
    "xlim": _limits("set_xlim"),
    "ylim": _limits("set_ylim"),
    "zlim": _limits("set_zlim"),
    "view": _view,
}
"""Function that draws each call; others, such as drawnow, draw nothing."""
