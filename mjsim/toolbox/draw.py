"""Draws recorded calls of figure functions with matplotlib."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

import numpy as np
from matplotlib import colormaps, rc
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from mjsim.geometry import Array
from mjsim.toolbox.calls import FigureCall
from mjsim.toolbox.figure_names import NOT_DRAWN
from mjsim.toolbox.panes import ORDER, ArmMotion, AxesPane, draw_motion, overlap
from mjsim.toolbox.properties import set_on

AXES = ("axes", "gca", "subplot", "nexttile", "newplot")
"""Functions that return handles of axes; the fraction of such a handle is HANDLE."""
HANDLE = 2.0**-13
ALL = 2.0**-12
"""Fraction of a handle that stands for everything that its call drew."""
LINE = 2.0**-20
"""Lines of one call have handles that differ by this."""
DEVICES = {"eps": "eps", "ps": "eps", "svg": "svg", "jpg": "jpg", "jpeg": "jpg", "tif": "tiff", "tiff": "tiff"}
"""Formats of `print` and `saveas`, without the letter for colour, beside PNG and PDF."""
DEFAULTS: Mapping[str, tuple[Literal["lines", "font"], str]] = {
    "defaultlinelinewidth": ("lines", "linewidth"),
    "defaultlinemarkersize": ("lines", "markersize"),
    "defaultaxesfontsize": ("font", "size"),
    "defaulttextfontsize": ("font", "size"),
}
"""Properties of all figures that a script may choose, in lower case, and the parameters of matplotlib."""
SETTINGS = ("view", "axis", "xlim", "ylim", "zlim", "xlabel", "ylabel", "zlabel", "daspect")
"""Functions that set limits, scales and labels of axes."""

Drawing = Callable[["ScriptFigures", FigureCall], Any]
"""Draws a call; returns the artists to which its handle refers, if any."""


class ScriptFigures:
    """Figures by number, as the calls so far have drawn them."""

    def __init__(self) -> None:
        """Start without figures."""
        self.figures: dict[int, Figure] = {}
        self.files: list[tuple[int, str]] = []
        """Figures that the script itself prints, with the names it gives them."""
        self.motions: dict[int, list[ArmMotion]] = {}
        self.driven: Mapping[str, Any] | None = None
        """Fields of the arm that `drivebot` was called for last."""
        self.start: Array = np.zeros(0)
        """Its joints at that call [rad, m]."""
        self.skipped: set[str] = set()
        """Functions that could not be drawn as called."""
        self._panes: dict[int, dict[Any, AxesPane]] = {}
        self._grids: dict[tuple[int, int, int], Any] = {}
        self._current: dict[int, AxesPane] = {}
        self._handles: dict[int, list[Any]] = {}
        self._sides: list[tuple[AxesPane, AxesPane]] = []
        self._tiles: dict[int, tuple[int, int, int]] = {}
        self._maps: dict[int, Any] = {}
        self._axes: dict[int, tuple[int, AxesPane]] = {}
        self._after: list[tuple[AxesPane, Callable[[Any], None]]] = []
        self.frames: dict[int, Any] = {}
        """Pictures that the script took, by the number of the call."""
        self.films: dict[str, tuple[float, list[Any]]] = {}
        """Frames in a second, and frames, of the films and pictures that the script wrote, by name."""
        self.resolutions: dict[str, int] = {}
        """Resolution that the script wants, by the name of the file [dots per inch]."""

    def draw(self, calls: Iterable[FigureCall], functions: Mapping[str, Drawing]) -> None:
        """Draw calls in order, each by the function of its name; others draw nothing."""
        for recorded in calls:
            call = self._in_its_axes(recorded)
            function = functions.get(call.name)
            if call.name in NOT_DRAWN:
                self.skipped.add(f"{call.name} is left out")
            try:
                if function is not None and (made := function(self, call)):
                    self._handles[call.number] = list(made)
            except (ValueError, TypeError, IndexError, KeyError, AttributeError) as error:
                self.skipped.add(f"{call.name}: {str(error).splitlines()[0] if str(error) else type(error).__name__}")
            if call.name in SETTINGS and call.figure in self._current:
                self._current[call.figure].settings.append(call)
            if call.name in AXES and call.figure in self._current:
                self._axes[call.number] = call.figure, self._current[call.figure]
        for motions in self.motions.values():
            for motion in motions:
                if motion.pane is not None:
                    draw_motion(motion, motion.postures())
        for figure, panes in self._panes.items():
            for pane in panes.values():
                self.settle(figure, pane, functions)
        for pane, change in self._after:
            change(pane.axes)

    def settle(self, figure: int, pane: AxesPane, functions: Mapping[str, Drawing]) -> None:
        """Repeat a script's settings of 3-D axes: arms set limits too, and equal scales depend on them."""
        if pane.axes.name == "3d" and pane.settings:
            self._current[figure] = pane
            for call in pane.settings:
                functions[call.name](self, call)

    def after_all(self, figure: int, change: Callable[[Any], None]) -> None:
        """Change the current axes of a figure after everything is drawn."""
        self._after.append((self.pane(figure), change))

    def _in_its_axes(self, call: FigureCall) -> FigureCall:
        """Return a call without the handle of axes before its arguments; these become the current ones."""
        first = call.arguments[0] if call.arguments else None
        if not isinstance(first, np.ndarray) or first.size != 1 or call.name in ("set", "label_of"):
            return call
        number, part = divmod(float(first.ravel()[0]), 1.0)
        if part != HANDLE or int(number) not in self._axes:
            return call
        figure, pane = self._axes[int(number)]
        self._current[figure] = pane
        return replace(call, figure=figure, arguments=call.arguments[1:])

    def figure(self, number: int) -> Figure:
        """Return a figure, made if necessary."""
        if number not in self.figures:
            self.figures[number] = Figure(figsize=(7.0, 5.2), layout="constrained")
            FigureCanvasAgg(self.figures[number])
            self._panes[number] = {}
        return self.figures[number]

    def pane(self, number: int, *, solid: bool | None = None) -> AxesPane:
        """Return the current axes of a figure, recreated if they are not of the kind needed (3-D or 2-D; None: any)."""
        figure = self.figure(number)
        if number not in self._current:
            spec = figure.add_gridspec(1, 1)[0, 0]
            self._panes[number][()] = self._current[number] = AxesPane(figure.add_subplot(spec), spec)
        pane = self._current[number]
        if solid and pane.axes.name != "3d":
            title = pane.axes.get_title()
            pane.axes.remove()
            pane.axes = figure.add_subplot(pane.spec, projection="3d")
            pane.axes.set_title(title)
        return pane

    def cleared(self, number: int, *, solid: bool = False) -> AxesPane:
        """Return axes for a new plot: emptied unless they are held."""
        pane = self.pane(number, solid=solid)
        if not pane.hold:
            if pane.axes.name == "3d" and not solid:
                pane.axes.remove()
                pane.axes = self.figure(number).add_subplot(pane.spec)
            if pane.labelled or pane.axes.has_data():
                pane.axes.clear()
                self.motions[number] = [m for m in self.motions.get(number, []) if m.pane is not pane]
            pane.lines, pane.labelled, pane.settings = pane.first, [], []
        return pane

    def subplot(self, call: FigureCall) -> None:
        """Choose axes of a grid."""
        numbers = [np.ravel(each) for each in call.arguments if isinstance(each, np.ndarray)]
        if len(numbers) == 1:
            value = int(numbers[0][0])
            numbers = [np.array([value // 100]), np.array([value // 10 % 10]), np.array([value % 10])]
        rows, columns = int(numbers[0][0]), int(numbers[1][0])
        places = numbers[2].astype(int) - 1
        key = (rows, columns, *places.tolist())
        figure, panes = self.figure(call.figure), self._panes
        for other in [each for each in panes[call.figure] if overlap(each, key)]:
            self._remove(call.figure, other)
        if key not in panes[call.figure]:
            # Only axes of one grid make room for each other's labels.
            grid = self._grids.setdefault((call.figure, rows, columns), figure.add_gridspec(rows, columns))
            down, across = places // columns, places % columns
            spec = grid[int(down.min()) : int(down.max()) + 1, int(across.min()) : int(across.max()) + 1]
            panes[call.figure][key] = AxesPane(figure.add_subplot(spec), spec)
        self._current[call.figure] = panes[call.figure][key]

    def _remove(self, number: int, key: Any) -> None:
        """Remove axes that others cover; the film of an arm that moved there stays."""
        pane = self._panes[number].pop(key)
        for other in (side for pair in self._sides if pane in pair for side in pair):
            if other.axes.figure is not None:
                other.axes.remove()
        if pane.axes.figure is not None:
            pane.axes.remove()
        self._sides = [pair for pair in self._sides if pane not in pair]
        self._after = [each for each in self._after if each[0] is not pane]
        for motion in self.motions.get(number, []):
            motion.pane = None if motion.pane is pane else motion.pane

    def close(self, call: FigureCall) -> None:
        """Keep figures that are closed at the end of a script; those closed at its start do not exist yet."""

    def clear_figure(self, call: FigureCall) -> None:
        """Empty a figure."""
        for each in (self.figures, self._panes, self._current, self.motions):
            each.pop(call.figure, None)
        self._grids = {key: grid for key, grid in self._grids.items() if key[0] != call.figure}

    def save(self, call: FigureCall) -> None:
        """Store the name under which the script saves the figure."""
        words = [word for word in call.arguments if isinstance(word, str)]
        names, device = [word for word in words if not word.startswith("-")], ""
        for word in (*words, *names[1:2]):
            device = DEVICES.get(word.removeprefix("-d").rstrip("c0123456789"), device)
        if names:
            file = names[0] if Path(names[0]).suffix else f"{names[0]}.{device or 'png'}"
            self.files.append((call.figure, file))
            dots = next((each[2:] for each in words if each.startswith("-r") and each[2:].isdigit()), None)
            for key, value in pairwise(call.arguments):
                if isinstance(key, str) and key.lower() == "resolution" and isinstance(value, np.ndarray):
                    dots = str(int(np.ravel(value)[0]))
            if dots is not None:
                self.resolutions[Path(file).stem] = int(dots)

    def choose_side(self, call: FigureCall) -> list[Any]:
        """Choose the axes of the left or of the right scale."""
        pane = self.pane(call.figure)
        left, right = next((pair for pair in self._sides if pane in pair), (pane, None))
        if right is None:
            right = AxesPane(pane.axes.twinx(), pane.spec, first=1, lines=1)
            left.axes.tick_params(axis="y", colors=ORDER[0])
            right.axes.tick_params(axis="y", colors=ORDER[1])
            self._sides.append((left, right))
        self._current[call.figure] = right if "right" in call.arguments else left
        return [self._current[call.figure].axes]

    def tile(self, call: FigureCall) -> None:
        """Begin a grid of tiles."""
        numbers = [int(np.ravel(each)[0]) for each in call.arguments if isinstance(each, np.ndarray)]
        self._tiles[call.figure] = (*(numbers if len(numbers) == 2 else (2, 2)), 0)

    def next_tile(self, call: FigureCall) -> list[Any]:
        """Choose the next tile, or that of a number."""
        rows, columns, before = self._tiles.get(call.figure, (1, 1, 0))
        number = int(np.ravel(call.arguments[0])[0]) if call.arguments else before % (rows * columns) + 1
        self._tiles[call.figure] = rows, columns, number
        self.subplot(replace(call, arguments=tuple(np.array([n]) for n in (rows, columns, number))))
        return [self._current[call.figure].axes]

    def add_axes(self, call: FigureCall) -> list[Any]:
        """Add axes at a position, or choose the current ones."""
        words = {key.lower(): v for key, v in zip(call.arguments[::2], call.arguments[1::2], strict=False)}
        if "position" in words:
            left, bottom, width, height = np.ravel(words["position"]).tolist()
            figure = self.figure(call.figure)
            spec = figure.add_gridspec(1, 1, left=left, bottom=bottom, right=left + width, top=bottom + height)[0, 0]
            axes = figure.add_axes((left, bottom, width, height))
            self._panes[call.figure][call.number] = self._current[call.figure] = AxesPane(axes, spec)
        return [self.pane(call.figure).axes]

    def map_of(self, number: int) -> Any:
        """Return the colour map of a figure."""
        return self._maps.get(number, "viridis")

    def set_map(self, number: int, value: Any) -> None:
        """Choose the colour map of a figure, by its name or as colours, shape (n, 3)."""
        made = ListedColormap(value) if isinstance(value, np.ndarray) and value.ndim == 2 else str(value)
        if isinstance(made, str) and made not in colormaps:
            return
        self._maps[number] = made
        for axes in self.figure(number).axes:
            for artist in (*axes.images, *(each for each in axes.collections if each.get_array() is not None)):
                artist.set_cmap(made)

    def set_properties(self, call: FigureCall) -> None:
        """Set properties of the artists to which a handle refers."""
        if not call.arguments or not isinstance(call.arguments[0], np.ndarray):
            return
        handles, words = np.ravel(call.arguments[0]).tolist(), call.arguments[1:]
        if handles == [0.0]:
            self._set_defaults(words)
            return
        # A cell of names goes with a cell that has a row of values for each handle.
        cells = len(words) == 2 and isinstance(words[0], list) and isinstance(words[1], list)
        for row, handle in enumerate(handles):
            pairs = list(words)
            if cells:
                values = words[1][row :: len(handles)] if len(words[1]) > len(words[0]) else words[1]
                pairs = [each for pair in zip(words[0], values, strict=False) for each in pair]
            for artist in self.artists(handle):
                set_on(artist, pairs)

    def _set_defaults(self, words: Sequence[Any]) -> None:
        """Set line widths and font sizes for everything drawn from now on; report other defaults."""
        for name, value in zip(words[::2], words[1::2], strict=False):
            if str(name).lower() in DEFAULTS:
                group, key = DEFAULTS[str(name).lower()]
                rc(group, **{key: float(np.ravel(value)[0])})
            elif str(name).lower().startswith("default"):
                self.skipped.add(f"set: {name} of all figures is left out")

    def artists(self, handle: float) -> list[Any]:
        """Return the artists to which a handle refers: axes, a line, or all that its call made."""
        number, part = divmod(float(handle), 1.0)
        artists = self._handles.get(int(number), [])
        if part == HANDLE and int(number) in self._axes:
            return [self._axes[int(number)][1].axes]
        if part == ALL:
            return artists
        line = round(part / LINE)
        return artists[line : line + 1] if len(artists) > 1 else artists

    def rename(self, handle: float, artist: Any) -> None:
        """Let a handle name another artist."""
        self._handles[int(handle)] = [artist]

    def delete(self, call: FigureCall) -> None:
        """Remove the artists to which handles refer."""
        for handle in np.ravel(call.arguments[0]).tolist() if call.arguments else []:
            for artist in self.artists(handle):
                artist.remove()
                for pane in self._panes.get(call.figure, {}).values():
                    pane.labelled = [each for each in pane.labelled if each is not artist]
