"""Functions of MATLAB that draw surfaces, and their levels, by name."""

from collections.abc import Mapping
from importlib import import_module
from typing import Any

import numpy as np
from matplotlib import cm

from mjsim.geometry import Array
from mjsim.toolbox.calls import FigureCall
from mjsim.toolbox.draw import Drawing, ScriptFigures
from mjsim.toolbox.marks import as_columns, data_of, words_of
from mjsim.toolbox.panes import ORDER

GRIDS = ("surf", "mesh", "contour", "contourf", "contour3")


def _grid(data: list[Array]) -> tuple[list[Array], list[Array]]:
    """Return x, y and z as matrices, and what comes after them."""
    if len(data) < 3 or (data[0].shape != data[2].shape and data[0].size * data[1].size != data[2].size):
        rows, columns = data[0].shape
        data = [*np.meshgrid(np.arange(1.0, columns + 1), np.arange(1.0, rows + 1)), *data]
    x, y, z = data[:3]
    if 1 in x.shape and 1 not in z.shape:
        x, y = np.meshgrid(np.ravel(x), np.ravel(y))
    return [x, y, z], data[3:]


def _surface(kind: str) -> Drawing:
    def drawing(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
        pane = drawn.cleared(call.figure, solid=True)
        (x, y, z), rest = _grid(data_of(call))
        words, _ = words_of(call)
        edge: dict[str, Any] = {key: words[key] for key in ("alpha", "linewidth") if key in words}
        if kind == "mesh":
            if words.get("edgecolor"):
                return [pane.axes.plot_wireframe(x, y, z, **({"lw": 0.7, "color": words["edgecolor"]} | edge))]
            lines: dict[str, Any] = {"cmap": drawn.map_of(call.figure), "rcount": 60, "ccount": 60, "lw": 0.8, **edge}
            made = pane.axes.plot_surface(x, y, z, **lines)
            # Its edges have the colours of the heights, and its faces hide what is behind them.
            made.mjsim_scale = cm.ScalarMappable(made.norm, made.cmap)
            made.set_edgecolor(made.to_rgba(made.get_array()))
            made.set_array(None)
            made.set_facecolor("white")
            return [made, *_levels_below(pane.axes, call, (x, y, z), drawn)]
        drawing: dict[str, Any] = {"rcount": 80, "ccount": 80, "lw": 0.2, "edgecolor": "#00000040", **edge}
        face = words.get("facecolor")
        if words.get("edgecolor"):
            drawing["edgecolor"] = words["edgecolor"]
        drawing |= {"color": face} if face and face != "none" else {"cmap": drawn.map_of(call.figure)}
        if rest and rest[0].shape == z.shape and "cmap" in drawing:
            # A fourth matrix has the colours.
            from matplotlib import colormaps

            low, high = float(np.nanmin(rest[0])), float(np.nanmax(rest[0]))
            drawing["facecolors"] = colormaps[drawing.pop("cmap")]((rest[0] - low) / ((high - low) or 1.0))
        return [pane.axes.plot_surface(x, y, z, **drawing), *_levels_below(pane.axes, call, (x, y, z), drawn)]

    return drawing


def _levels_below(axes: Any, call: FigureCall, data: tuple[Array, ...], drawn: ScriptFigures) -> list[Any]:
    """Draw the levels of surfc and meshc on the floor."""
    if call.name not in ("surfc", "meshc"):
        return []
    low = float(np.nanmin(data[2]) - 0.5 * np.ptp(data[2][np.isfinite(data[2])]))
    return [axes.contour(*data, 10, zdir="z", offset=low, cmap=drawn.map_of(call.figure))]


def _levels(method: str) -> Drawing:
    def drawing(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
        pane = drawn.cleared(call.figure, solid=method == "contour3")
        (x, y, z), rest = _grid(data_of(call)) if len(data_of(call)) != 2 else _grid_of_two(data_of(call))
        words, given = words_of(call)
        chosen: Any = 10
        if rest:
            values = np.unique(np.ravel(rest[0]))
            chosen = int(values[0]) if rest[0].size == 1 else values
        drawing: dict[str, Any] = {"levels": chosen}
        color = words.get("color") or words.get("linecolor")
        drawing |= {"colors": [color], "negative_linestyles": "solid"} if color else {"cmap": drawn.map_of(call.figure)}
        if method != "contourf":
            drawing |= {"linewidths": words["linewidth"]} if "linewidth" in words else {}
            drawing |= {"linestyles": words["linestyle"]} if words.get("linestyle", "none") != "none" else {}
        made = getattr(pane.axes, "contour" if method == "contour3" else method)(x, y, z, **drawing)
        if method == "contourf":
            edges = {"colors": "black", "linewidths": 0.5, "negative_linestyles": "solid"}
            made.mjsim_edges = pane.axes.contour(x, y, z, levels=made.levels, **edges)
        if given.get("showtext") == "on":
            getattr(made, "mjsim_edges", made).clabel(fontsize=8)
        pane.labelled.append(made.legend_elements()[0][0] if method == "contour" and len(made.levels) else made)
        return [made]

    return drawing


def _grid_of_two(data: list[Array]) -> tuple[list[Array], list[Array]]:
    found, _ = _grid(data[:1])
    return found, data[1:]


def _labels(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
    """Label the levels of a contour."""
    handles = np.ravel(data_of(call)[-1]).tolist() if data_of(call) else []
    for artist in (each for handle in handles for each in drawn.artists(handle) if hasattr(each, "clabel")):
        # Labels cut gaps into what they label: of filled levels into their edges.
        getattr(artist, "mjsim_edges", artist).clabel(fontsize=8)
    return []


def _triangles(kind: str) -> Drawing:
    def drawing(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
        faces, x, y, *rest = data_of(call)
        corners = faces.astype(int) - 1
        points = [np.ravel(x), np.ravel(y), *(np.ravel(each) for each in rest[:1])]
        pane = drawn.cleared(call.figure, solid=bool(rest))
        if not rest:
            return list(pane.axes.triplot(*points, corners, color=ORDER[0], lw=0.8))
        fill = (
            {"cmap": drawn.map_of(call.figure)} if kind == "trisurf" else {"color": (1, 1, 1, 0), "edgecolor": ORDER[0]}
        )
        return [pane.axes.plot_trisurf(*points[:2], points[2], triangles=corners, lw=0.3, **fill)]

    return drawing


def _faces(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
    """Draw polygons in space: a column of each coordinate, or faces of vertices."""
    # mplot3d ships no types.
    art: Any = import_module("mpl_toolkits.mplot3d.art3d")

    pane, (words, given) = drawn.pane(call.figure, solid=True), words_of(call)
    if "vertices" in given and "faces" in given:
        corners = [row[np.isfinite(row)].astype(int) - 1 for row in np.atleast_2d(given["faces"])]
        outlines = [given["vertices"][row] for row in corners]
    else:
        named = [given[key] for key in ("xdata", "ydata", "zdata") if key in given]
        columns = [as_columns(each) for each in (data_of(call)[:3] or named)]
        outlines = [np.column_stack(each) for each in zip(*(part.T for part in columns), strict=True)]
    color = words.get("facecolor") or words.get("color") or ORDER[0]
    made = art.Poly3DCollection(outlines, alpha=words.get("alpha"), linewidths=words.get("linewidth", 0.6))
    made.set_facecolor(color)
    made.set_edgecolor(words.get("edgecolor", "black"))
    pane.axes.add_collection3d(made)
    pane.axes.auto_scale_xyz(*np.concatenate(outlines).T)
    pane.labelled.append(made)
    return [made]


def _stems(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
    (x, y, z), _ = _grid(data_of(call))
    made = drawn.cleared(call.figure, solid=True).axes.stem(*(np.ravel(each) for each in (x, y, z)), basefmt=" ")
    color = words_of(call)[0].get("color") or ORDER[0]
    made.stemlines.set_color(color)
    made.markerline.set_color(color)
    return [made.markerline]


def _blocks(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
    """Draw a block for each element of a matrix."""
    heights = np.atleast_2d(data_of(call)[-1])
    rows, columns = (np.ravel(each) for each in np.indices(heights.shape))
    colors = [ORDER[k % len(ORDER)] for k in columns]
    axes = drawn.cleared(call.figure, solid=True).axes
    return [axes.bar3d(columns + 0.6, rows + 0.6, 0.0 * rows, 0.8, 0.8, np.ravel(heights), color=colors)]


def _ribbons(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
    """Draw each column of a matrix as a strip."""
    heights, pane = np.atleast_2d(data_of(call)[-1]), drawn.cleared(call.figure, solid=True)
    y, made = np.arange(1.0, len(heights) + 1), []
    for k, column in enumerate(heights.T, start=1):
        x = np.array([k - 0.375, k + 0.375])
        z = np.repeat(column[:, None], 2, axis=1)
        made.append(pane.axes.plot_surface(*np.meshgrid(x, y), z, color=ORDER[(k - 1) % len(ORDER)]))
    return made


SOLID_FUNCTIONS: Mapping[str, Drawing] = {
    **{name: _surface("surf") for name in ("surf", "surfc", "surfl", "surface")},
    **{name: _surface("mesh") for name in ("mesh", "meshc", "meshz", "waterfall")},
    "contour": _levels("contour"),
    "contourf": _levels("contourf"),
    "contour3": _levels("contour3"),
    "clabel": _labels,
    "trisurf": _triangles("trisurf"),
    "trimesh": _triangles("trimesh"),
    "triplot": _triangles("trimesh"),
    "fill3": _faces,
    "stem3": _stems,
    "bar3": _blocks,
    "ribbon": _ribbons,
}
"""Functions that draw, by the names of their calls."""
