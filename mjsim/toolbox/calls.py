"""Calls of figure functions that Octave has recorded, as plain values."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mjsim.toolbox.figure_names import FIGURE_FUNCTIONS, INTERACTIVE


@dataclass(frozen=True, slots=True, eq=False)
class FigureCall:
    """One call: its arguments are arrays, text, lists and mappings."""

    name: str
    arguments: tuple[Any, ...]
    figure: int
    number: int
    """Handle that it returned."""


def write_recorders(folder: Path) -> None:
    """Write a function file for each recorded function, and for each that would wait for a person."""
    for name in FIGURE_FUNCTIONS:
        head = f"function varargout = {name}(varargin)\n% {name.upper()}  Recorded; mjsim draws it.\n"
        body = f"  [varargout{{1:max(nargout, 1)}}] = mjsim_recorded('{name}', varargin, nargout);\n"
        (folder / f"{name}.m").write_text(f"{head}{body}  if nargout == 0, varargout = {{}}; end\nend\n")
    for name in INTERACTIVE:
        told = f"{name} waits for input, but scripts run unattended here; write its answer into the script"
        (folder / f"{name}.m").write_text(f"function varargout = {name}(varargin)\n  error('{told}');\nend\n")


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
