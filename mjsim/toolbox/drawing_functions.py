"""Functions of MATLAB that draw, by name."""

from collections.abc import Callable, Mapping, Sequence
from itertools import takewhile
from typing import Any

import numpy as np

from mjsim.geometry import Array
from mjsim.toolbox.calls import FigureCall
from mjsim.toolbox.draw import ORDER, Drawing, ScriptFigures
from mjsim.toolbox.image_functions import IMAGE_FUNCTIONS
from mjsim.toolbox.marks import line_format, math_text, properties_of

PLACES = {"best": "best", "northeast": "upper right", "northwest": "upper left", "southeast": "lower right",
          "southwest": "lower left", "north": "upper center", "south": "lower center", "east": "center right",
          "west": "center left"}  # fmt: skip
"""Places of a legend."""


def _numbers(value: Any) -> Array:
    """Return data of a line as columns, shape (k, lines)."""
    array = np.asarray(value, dtype=float)
    return array.reshape(-1, 1) if array.ndim < 2 or 1 in array.shape else array


def _data(call: FigureCall) -> list[Array]:
    """Return the arrays before the first text; others are values of properties."""
    return list(takewhile(lambda each: isinstance(each, np.ndarray), call.arguments))


def _is_text(value: Any) -> bool:
    return isinstance(value, str)


def _groups(arguments: Sequence[Any], dimensions: int) -> tuple[list[tuple[list[Array], dict[str, Any]]], list[Any]]:
    """Return the data of each group of lines with its format, and the pairs of properties at the end."""
    rest = list(arguments)
    groups: list[tuple[list[Array], dict[str, Any]]] = []
    while rest and not _is_text(rest[0]):
        data: list[Array] = []
        while rest and not _is_text(rest[0]) and len(data) < dimensions:
            data.append(_numbers(rest.pop(0)))
        if dimensions == 2 and len(data) == 1:
            data.insert(0, np.arange(1.0, len(data[0]) + 1).reshape(-1, 1))
        style = line_format(rest[0]) if rest and _is_text(rest[0]) else None
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
        for data, style in groups:
            for column in _columns(data):
                keywords = {"color": ORDER[pane.lines % len(ORDER)], **style, **given}
                artists = draw(pane.axes)(*column, **{key: v for key, v in keywords.items() if v is not None})
                made.append(artists[0] if isinstance(artists, list) else artists)
                pane.lines += 1
        pane.labelled += made
        return made

    return drawing


def _line(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
    """Draw a line into axes that keep what they have."""
    data = _data(call)
    pane = drawn.pane(call.figure, solid=len(data) == 3)
    keywords = {"color": ORDER[0], **properties_of(call.arguments[len(data) :])}
    made = list(pane.axes.plot(*(np.ravel(each) for each in data), **keywords))
    pane.labelled += made
    return made


def _bars(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
    pane = drawn.cleared(call.figure)
    data = [_numbers(each) for each in _data(call)[:2]]
    x, heights = data if len(data) == 2 and data[1].size > 1 else (np.arange(1.0, len(data[0]) + 1), data[0])
    made = []
    apart = float(np.abs(np.diff(np.sort(np.ravel(x)))).min(initial=np.inf))
    width = 0.8 * (apart if 0.0 < apart < np.inf else 1.0) / heights.shape[1]
    for k in range(heights.shape[1]):
        offset = (k - (heights.shape[1] - 1) / 2) * width
        made.append(pane.axes.bar(np.ravel(x) + offset, heights[:, k], width=width, color=ORDER[k % len(ORDER)]))
    pane.labelled += made
    return made


def _area(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
    data = [np.ravel(each) for each in _data(call)[:2]]
    x, y = data if len(data) == 2 else (np.arange(1.0, len(data[0]) + 1), data[0])
    pane = drawn.cleared(call.figure)
    return [pane.axes.fill_between(x, y, color=ORDER[0], alpha=0.6)]


def _fill(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
    data = [np.ravel(each) for each in _data(call)[:2]]
    rest = call.arguments[len(data) :]
    style = line_format(rest[0]) if rest and _is_text(rest[0]) else None
    words = rest[1:] if style is not None else rest
    given = {str(key).lower(): value for key, value in zip(words[::2], words[1::2], strict=False)}
    colors = {"color": (style or {}).get("color", ORDER[0]), **properties_of(words)}
    if "facecolor" in colors:
        colors["edgecolor"] = colors.get("edgecolor", "black")
        del colors["color"]
    outlines = [data]
    if "vertices" in given and "faces" in given:
        faces = np.atleast_2d(given["faces"]).astype(int) - 1
        outlines = [[given["vertices"][face, 0], given["vertices"][face, 1]] for face in faces]
    axes = drawn.pane(call.figure).axes
    return [artist for outline in outlines for artist in axes.fill(*outline[:2], **colors)]


def _quiver(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
    data = _data(call)[:4]
    return [drawn.cleared(call.figure).axes.quiver(*data, color=ORDER[0])]


def _errors(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
    data = [np.ravel(each) for each in _data(call)[:3]]
    x, y, e = data if len(data) == 3 else (np.arange(1.0, len(data[0]) + 1), *data)
    pane = drawn.cleared(call.figure)
    made = [pane.axes.errorbar(x, y, yerr=e, color=ORDER[0], capsize=3)]
    pane.labelled += made
    return made


def _scatter(dimensions: int) -> Drawing:
    def drawing(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
        """Draw points, with their areas in square points, and their colours, after the coordinates."""
        data = [np.ravel(each) if each.shape[-1] != 3 else each for each in _data(call)]
        pane, words = drawn.cleared(call.figure, solid=dimensions == 3), call.arguments[len(data) :]
        sizes, colors = (data[k] if len(data) > k and data[k].size else None for k in (dimensions, dimensions + 1))
        style = next((each for each in map(line_format, filter(_is_text, words)) if each), {})
        chosen = style.get("color", ORDER[pane.lines % len(ORDER)]) if colors is None else colors
        points = [np.ravel(each) for each in data[:dimensions]]
        artist = pane.axes.scatter(*points, s=36 if sizes is None else sizes, c=chosen, marker=style.get("marker", "o"))
        if "filled" not in words:
            artist.set_facecolor("none")
            artist.set_edgecolor(chosen if isinstance(chosen, str) else None)
        pane.lines += 1
        pane.labelled.append(artist)
        return [artist]

    return drawing


def _polar(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
    """Draw a curve of angles and radii, with a grid of circles."""
    angle, radius = (np.ravel(each) for each in call.arguments[:2])
    pane = drawn.cleared(call.figure)
    pane.axes.set_aspect("equal")
    turn = np.linspace(0, 2 * np.pi, 200)
    for size in np.linspace(0, float(np.abs(radius).max()), 5)[1:]:
        pane.axes.plot(size * np.cos(turn), size * np.sin(turn), ":", color="#999999", lw=0.8)
    return list(pane.axes.plot(radius * np.cos(angle), radius * np.sin(angle), color=ORDER[0]))


def _surface(kind: str) -> Drawing:
    def drawing(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
        pane = drawn.cleared(call.figure, solid=kind != "contour")
        data = _data(call)
        if len(data) < 3 or data[0].size == 1:
            rows, columns = data[0].shape
            data = [*np.meshgrid(np.arange(1.0, columns + 1), np.arange(1.0, rows + 1)), *data]
        x, y, z = data[:3]
        if 1 in x.shape:
            x, y = np.meshgrid(np.ravel(x), np.ravel(y))
        if kind == "mesh":
            return [pane.axes.plot_wireframe(x, y, z, lw=0.7, color=ORDER[0])]
        if kind == "contour":
            return [pane.axes.contour(x, y, z, levels=10)]
        return [pane.axes.plot_surface(x, y, z, cmap="viridis", rcount=80, ccount=80, lw=0.2, edgecolor="#00000040")]

    return drawing


def _label(method: str) -> Drawing:
    def labelling(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
        axes = drawn.pane(call.figure).axes
        if not hasattr(axes, method):
            return []
        words = call.arguments[0] if call.arguments else ""
        text = "\n".join(words) if isinstance(words, list) else words
        return [getattr(axes, method)(math_text(text), **properties_of(call.arguments[1:]))]

    return labelling


def _main_title(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
    return [drawn.figure(call.figure).suptitle(math_text(call.arguments[0]))]


def _text(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
    place = [float(np.ravel(each)[0]) for each in _data(call)[:3]]
    words = [each for each in call.arguments if isinstance(each, str)]
    start = next(k for k, each in enumerate(call.arguments) if isinstance(each, str))
    axes = drawn.pane(call.figure).axes
    count = 3 if axes.name == "3d" else 2
    place = [*place, 0.0][:count]
    return [axes.text(*place, math_text(words[0]), **properties_of(call.arguments[start + 1 :]))]


def _legend(drawn: ScriptFigures, call: FigureCall) -> None:
    pane = drawn.pane(call.figure)
    words = [each for item in call.arguments for each in (item if isinstance(item, list) else [item])]
    words = [each for each in words if isinstance(each, str)]
    lower = [word.lower() for word in words]
    place = "best"
    if "location" in lower:
        at = lower.index("location")
        place = PLACES.get(lower[at + 1].removesuffix("outside"), "best") if at + 1 < len(lower) else "best"
        words = words[:at] + words[at + 2 :]
    if lower in (["off"], ["hide"]):
        return
    handles = pane.labelled or [*pane.axes.lines]
    if words in ([], ["show"]):
        pane.axes.legend(loc=place)
        return
    count = min(len(handles), len(words))
    pane.axes.legend(handles[:count], [math_text(word) for word in words[:count]], loc=place)


def _hold(drawn: ScriptFigures, call: FigureCall) -> None:
    pane = drawn.pane(call.figure)
    word = call.arguments[-1] if call.arguments and isinstance(call.arguments[-1], str) else None
    pane.hold = not pane.hold if word is None else word != "off"


def _grid(drawn: ScriptFigures, call: FigureCall) -> None:
    words = [each for each in call.arguments if isinstance(each, str)]
    drawn.pane(call.figure).axes.grid(visible="off" not in words, alpha=0.4)


def _axis(drawn: ScriptFigures, call: FigureCall) -> None:
    axes = drawn.pane(call.figure).axes
    for word in call.arguments:
        if isinstance(word, np.ndarray) and word.size >= 4:
            limits = np.ravel(word)
            for setter, pair in zip(("set_xlim", "set_ylim", "set_zlim"), limits.reshape(-1, 2), strict=False):
                if hasattr(axes, setter):
                    getattr(axes, setter)(*pair)
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
    _keep_limits(axes)


def _keep_limits(axes: Any) -> None:
    """Give axes of equal scales a box of their limits, if these are fixed."""
    if axes.name != "3d" and axes.get_aspect() != "auto" and not axes.get_autoscalex_on():
        axes.set_aspect("equal", adjustable="box")


def _limits(method: str) -> Drawing:
    def limiting(drawn: ScriptFigures, call: FigureCall) -> None:
        axes = drawn.pane(call.figure).axes
        if call.arguments and isinstance(call.arguments[0], np.ndarray) and hasattr(axes, method):
            getattr(axes, method)(*np.ravel(call.arguments[0])[:2])
            _keep_limits(axes)

    return limiting


def _view(drawn: ScriptFigures, call: FigureCall) -> None:
    axes = drawn.pane(call.figure).axes
    numbers = [float(each) for part in call.arguments if isinstance(part, np.ndarray) for each in np.ravel(part)]
    if axes.name == "3d" and numbers:
        azimuth, elevation = numbers if len(numbers) == 2 else ((-37.5, 30.0) if numbers == [3.0] else (0.0, 90.0))
        # MATLAB counts the azimuth from the negative y axis.
        axes.view_init(elev=elevation, azim=azimuth - 90.0)


def _colorbar(drawn: ScriptFigures, call: FigureCall) -> None:
    pane = drawn.pane(call.figure)
    mapped = [each for each in pane.axes.collections if each.get_array() is not None]
    if mapped:
        drawn.figure(call.figure).colorbar(mapped[-1], ax=pane.axes)


def _figure(drawn: ScriptFigures, call: FigureCall) -> None:
    drawn.figure(call.figure)


def _choose(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
    return [drawn.pane(call.figure).axes]


def _clear(drawn: ScriptFigures, call: FigureCall) -> None:
    pane = drawn.pane(call.figure)
    pane.axes.clear()
    pane.lines, pane.labelled, pane.hold = 0, [], False
    drawn.motions[call.figure] = [motion for motion in drawn.motions.get(call.figure, []) if motion.pane is not pane]


FUNCTIONS: Mapping[str, Drawing] = {
    **IMAGE_FUNCTIONS,
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
    "robot": ScriptFigures.robot,
    "drive": ScriptFigures.drive,
    "plot": _lines(lambda axes: axes.plot),
    "semilogx": _lines(lambda axes: axes.semilogx),
    "semilogy": _lines(lambda axes: axes.semilogy),
    "loglog": _lines(lambda axes: axes.loglog),
    "stairs": _lines(lambda axes: lambda *data, **words: axes.step(*data, where="post", **words)),
    "stem": _lines(lambda axes: lambda x, y, **words: axes.stem(x, y)),
    "scatter": _scatter(2),
    "plot3": _lines(lambda axes: axes.plot, 3),
    "scatter3": _scatter(3),
    "line": _line,
    "bar": _bars,
    "area": _area,
    "errorbar": _errors,
    "fill": _fill,
    "patch": _fill,
    "quiver": _quiver,
    "polar": _polar,
    "polarplot": _polar,
    "surf": _surface("surf"),
    "surfc": _surface("surf"),
    "mesh": _surface("mesh"),
    "meshc": _surface("mesh"),
    "contour": _surface("contour"),
    "waterfall": _surface("mesh"),
    "title": _label("set_title"),
    "xlabel": _label("set_xlabel"),
    "ylabel": _label("set_ylabel"),
    "zlabel": _label("set_zlabel"),
    "sgtitle": _main_title,
    "suptitle": _main_title,
    "text": _text,
    "legend": _legend,
    "hold": _hold,
    "grid": _grid,
    "axis": _axis,
    "xlim": _limits("set_xlim"),
    "ylim": _limits("set_ylim"),
    "zlim": _limits("set_zlim"),
    "view": _view,
    "colorbar": _colorbar,
}
"""What draws each call; others, such as drawnow, draw nothing."""
