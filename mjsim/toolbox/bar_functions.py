"""Functions of MATLAB that draw bars, areas, errors, arrows and reference lines, by name."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from mjsim.geometry import Array
from mjsim.toolbox.calls import FigureCall
from mjsim.toolbox.draw import Drawing, ScriptFigures
from mjsim.toolbox.marks import as_columns, data_of, is_text, math_text, words_of
from mjsim.toolbox.panes import ORDER


def _faces(words: dict[str, Any], default: str) -> dict[str, Any]:
    """Return the keywords of a filled shape."""
    face = words.pop("facecolor", None) or words.pop("color", None) or default
    return {**{key: value for key, value in words.items() if value is not None}, "facecolor": face}


def _bars(*, flat: bool) -> Drawing:
    def drawing(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
        pane, (words, _) = drawn.cleared(call.figure), words_of(call)
        data = [as_columns(each) for each in data_of(call)[:2]]
        x, heights = data if len(data) == 2 and data[1].size > 1 else (np.arange(1.0, len(data[0]) + 1), data[0])
        numbers = [float(np.ravel(each)[0]) for each in data_of(call)[1:] if each.size == 1]
        share = numbers[-1] if numbers and heights.size > 1 else 0.8
        stacked = any(word in ("stacked", "stack") for word in call.arguments if is_text(word))
        apart = float(np.abs(np.diff(np.sort(np.ravel(x)))).min(initial=np.inf))
        groups = 1 if stacked else heights.shape[1]
        width, made, base = share * (apart if 0.0 < apart < np.inf else 1.0) / groups, [], np.zeros(len(heights))
        for k, column in enumerate(heights.T):
            offset = 0.0 if stacked else (k - (groups - 1) / 2) * width
            keywords = _faces({key: v for key, v in words.items() if key != "marker"}, ORDER[k % len(ORDER)])
            if flat:
                made.append(pane.axes.barh(np.ravel(x) + offset, column, height=width, left=base, **keywords))
            else:
                made.append(pane.axes.bar(np.ravel(x) + offset, column, width=width, bottom=base, **keywords))
            base = base + column if stacked else base
        pane.labelled += made
        return made

    return drawing


def _area(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
    """Draw areas on top of each other."""
    data, (words, _) = [as_columns(each) for each in data_of(call)[:2]], words_of(call)
    x, y = data if len(data) == 2 and data[1].size > 1 else (np.arange(1.0, len(data[0]) + 1), data[0])
    pane, below, made = drawn.cleared(call.figure), np.zeros(len(y)), []
    for k, column in enumerate(y.T):
        keywords = _faces(dict(words), ORDER[k % len(ORDER)])
        made.append(pane.axes.fill_between(np.ravel(x), below, below + column, **keywords))
        below = below + column
    pane.labelled += made
    return made


def _errors(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
    data, (words, _) = [np.ravel(each) for each in data_of(call)], words_of(call)
    x = data.pop(0) if len(data) > 2 else np.arange(1.0, len(data[0]) + 1)
    y, *errors = data[:3]
    pane = drawn.cleared(call.figure)
    keywords = {"color": ORDER[pane.lines % len(ORDER)], **{key: v for key, v in words.items() if v is not None}}
    across = any(word == "horizontal" for word in call.arguments if is_text(word))
    size: Any = errors[0] if len(errors) == 1 else np.array(errors)
    made = [pane.axes.errorbar(x, y, capsize=3, **({"xerr": size} if across else {"yerr": size}), **keywords)]
    pane.labelled += made
    pane.lines += 1
    return made


def _arrows(dimensions: int) -> Drawing:
    """Return a function that draws arrows from points, scaled to their spacing as MATLAB does by default."""

    def drawing(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
        data, (words, given) = data_of(call), words_of(call)
        scale = 1.0
        if len(data) in (3, 2 * dimensions + 1):
            scale = float(np.ravel(data.pop())[0])
        elif "autoscale" in given:
            scale = 0.0 if given["autoscale"] == "off" else 1.0
        if len(data) == 2:
            rows, columns = data[0].shape
            data = [*np.meshgrid(np.arange(1.0, columns + 1), np.arange(1.0, rows + 1)), *data]
        start, arrow = data[:dimensions], data[dimensions:]
        if start[0].shape != arrow[0].shape and start[0].size != arrow[0].size:
            start = list(np.meshgrid(*(np.ravel(each) for each in start)))
        start, arrow = [np.ravel(each) for each in start], [np.ravel(each) for each in arrow]
        if scale and arrow[0].size > 1:
            longest = float(np.nanmax(np.sqrt(sum(each**2 for each in arrow))))
            spacing = max(float(np.ptp(each)) for each in start) / max(np.sqrt(arrow[0].size), 1.0)
            arrow = [each * scale * spacing / longest for each in arrow] if longest and spacing else arrow
        pane = drawn.cleared(call.figure, solid=dimensions == 3)
        color = words.get("color") or ORDER[pane.lines % len(ORDER)]
        pane.lines += 1
        if dimensions == 3:
            made = pane.axes.quiver(*start, *arrow, color=color)
            ends = (np.append(each, each + step) for each, step in zip(start, arrow, strict=True))
            pane.axes.auto_scale_xyz(*ends)
        else:
            made = pane.axes.quiver(*start, *arrow, color=color, angles="xy", scale_units="xy", scale=1.0, width=0.004)
            pane.axes.update_datalim(np.column_stack([start[0] + arrow[0], start[1] + arrow[1]]))
            pane.axes.autoscale_view()
        pane.labelled.append(made)
        return [made]

    return drawing


def _from_origin(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
    """Draw arrows from the origin."""
    u, v = (np.ravel(each) for each in data_of(call)[:2])
    pane = drawn.cleared(call.figure)
    pane.axes.set_aspect("equal", adjustable="datalim")
    none = np.zeros(len(u))
    made = pane.axes.quiver(none, none, u, v, color=ORDER[0], angles="xy", scale_units="xy", scale=1.0)
    pane.axes.update_datalim(np.column_stack([u, v]))
    pane.axes.autoscale_view()
    return [made]


def _along(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
    """Draw arrows from points along an axis."""
    u, v = (np.ravel(each) for each in data_of(call)[:2])
    x = np.arange(1.0, len(u) + 1)
    axes = drawn.cleared(call.figure).axes
    made = axes.quiver(x, 0.0 * x, u, v, color=ORDER[0], angles="xy", scale_units="xy", scale=1.0)
    axes.update_datalim(np.column_stack([x + u, v]))
    axes.autoscale_view()
    return [made]


def _reference(method: str) -> Drawing:
    """Return a function that draws lines across the axes, with a label."""

    def drawing(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
        pane, made = drawn.pane(call.figure), []
        words, _ = words_of(call)
        rest = [each for each in call.arguments[1:] if is_text(each)]
        label = rest[1] if len(rest) == 2 and len(call.arguments) == 3 else ""
        for value in np.ravel(call.arguments[0]).tolist():
            made.append(getattr(pane.axes, method)(value, **{"color": "#404040", **words}))
            if label:
                across = pane.axes.get_yaxis_transform() if method == "axhline" else pane.axes.get_xaxis_transform()
                place = (0.99, value) if method == "axhline" else (value, 0.98)
                turn = 0 if method == "axhline" else 90
                side = {"ha": "right", "va": "bottom" if method == "axhline" else "top"}
                pane.axes.text(*place, math_text(label), transform=across, rotation=turn, **side)
        pane.labelled += made
        return made

    return drawing


def _circles(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
    """Draw circles of centres, shape (n, 2), and radii."""
    centres, radii = data_of(call)[:2]
    pane, (words, _) = drawn.pane(call.figure), words_of(call)
    turn, made = np.linspace(0.0, 2.0 * np.pi, 100), []
    for (x, y), radius in zip(np.atleast_2d(centres), np.broadcast_to(np.ravel(radii), len(centres)), strict=True):
        made += pane.axes.plot(x + radius * np.cos(turn), y + radius * np.sin(turn), **{"color": "#d00000", **words})
    pane.axes.set_aspect("equal", adjustable="datalim")
    return made


def _rose(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
    """Draw the counts of angles as sectors."""
    data: list[Array] = data_of(call)
    bins = int(np.ravel(data[1])[0]) if len(data) > 1 and data[1].size == 1 else 20
    count, edges = np.histogram(np.mod(np.ravel(data[0]), 2 * np.pi), bins, (0.0, 2 * np.pi))
    pane = drawn.cleared(call.figure)
    pane.axes.set_aspect("equal", adjustable="datalim")
    made = []
    for size, low, high in zip(count, edges[:-1], edges[1:], strict=True):
        angle = np.concatenate([[low], np.linspace(low, high, 8), [high]])
        radius = np.concatenate([[0.0], np.full(8, float(size)), [0.0]])
        made += pane.axes.plot(radius * np.cos(angle), radius * np.sin(angle), color=ORDER[0])
    return made


def _boxes(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
    """Draw the quartiles of each column."""
    axes = drawn.cleared(call.figure).axes
    axes.boxplot(as_columns(data_of(call)[0]))
    return [axes]


BAR_FUNCTIONS: Mapping[str, Drawing] = {
    "bar": _bars(flat=False),
    "barh": _bars(flat=True),
    "area": _area,
    "errorbar": _errors,
    "quiver": _arrows(2),
    "quiver3": _arrows(3),
    "compass": _from_origin,
    "feather": _along,
    "xline": _reference("axvline"),
    "yline": _reference("axhline"),
    "viscircles": _circles,
    "rose": _rose,
    "boxplot": _boxes,
}
"""Functions that draw, by the names of their calls."""
