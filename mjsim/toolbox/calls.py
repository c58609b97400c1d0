"""Calls of figure functions that Octave has recorded, as plain values."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

FIGURE_FUNCTIONS = (
    *("figure", "subplot", "axes", "hold", "clf", "cla", "close", "closereq", "drawnow", "pause", "set", "gca"),
    *("plot", "plot3", "line", "semilogx", "semilogy", "loglog", "stairs", "stem", "bar", "area", "errorbar"),
    *("fill", "patch", "quiver", "polar", "scatter", "scatter3", "surf", "mesh", "contour", "surfc", "meshc"),
    *("title", "xlabel", "ylabel", "zlabel", "legend", "text", "grid", "axis", "xlim", "ylim", "zlim", "view"),
    *("imshow", "image", "imagesc", "pcolor", "contourf", "histogram", "pie", "barh", "rectangle", "polarplot"),
    *("xticks", "yticks", "xticklabels", "yticklabels", "caxis", "clim", "yyaxis", "tiledlayout", "nexttile"),
    *("annotation", "waitbar", "rotate3d", "camproj", "lighting", "material", "light", "hidden", "zoom", "pan"),
    *("exportgraphics", "waterfall", "sgrid", "zgrid"),
    *("colormap", "colorbar", "shading", "box", "print", "saveas", "sgtitle", "suptitle", "refresh", "camlight"),
)
"""Functions that are recorded instead of opening windows."""


@dataclass(frozen=True, slots=True, eq=False)
class FigureCall:
    """One call: its arguments are arrays, text, lists and mappings."""

    name: str
    arguments: tuple[Any, ...]
    figure: int
    number: int
    """Handle that it returned."""


def write_recorders(folder: Path) -> None:
    """Write a function file for each recorded function."""
    for name in FIGURE_FUNCTIONS:
        head = f"function varargout = {name}(varargin)\n% {name.upper()}  Recorded; mjsim draws it.\n"
        body = f"  id = mjsim_record('{name}', varargin);\n  if nargout > 0, varargout{{1}} = id; end\nend\n"
        (folder / f"{name}.m").write_text(head + body)


def read_calls(file: Path) -> Iterator[FigureCall]:
    """Yield the calls of a file that `mjsim_record` wrote."""
    from scipy.io import loadmat

    for item in np.ravel(loadmat(file)["calls"]):
        name, arguments, figure, number = np.ravel(item)
        values = tuple(_plain(each) for each in np.ravel(arguments))
        yield FigureCall(_plain(name), values, int(np.ravel(figure)[0]), int(np.ravel(number)[0]))


def _plain(value: Any) -> Any:
    if not isinstance(value, np.ndarray):
        return value
    if value.dtype.names == ("text",):
        return bytes(np.ravel(value["text"][0, 0]).astype(np.uint8)).decode("utf-8", errors="replace")
    if value.dtype.names:
        items = [{key: _plain(item[key]) for key in value.dtype.names} for item in value.ravel()]
        return items[0] if len(items) == 1 else items
    if value.dtype == object:
        return [_plain(each) for each in value.ravel()]
    return np.asarray(np.real(value), dtype=float)
