"""Properties that a script sets after it has drawn: data of lines and shapes, ticks and scales of axes, texts."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from mjsim.toolbox.marks import math_text, properties_of

DATA = ("xdata", "ydata", "zdata")


def set_on(artist: Any, words: Sequence[Any]) -> None:
    """Set pairs of names and values on a line, a shape, a text, an image or axes of matplotlib."""
    pairs = zip(words[::2], words[1::2], strict=False)
    given = {name.lower(): value for name, value in pairs if isinstance(name, str)}
    if any(key in given for key in DATA):
        _set_data(artist, [np.ravel(given[key]) if key in given else None for key in DATA])
    for key, value in properties_of(words).items():
        if value is not None and hasattr(artist, f"set_{key}"):
            getattr(artist, f"set_{key}")(value)
    if isinstance(given.get("string"), str) and hasattr(artist, "set_text"):
        artist.set_text(math_text(given["string"]))
    if given.get("visible") in ("on", "off"):
        artist.set_visible(given["visible"] == "on")
    if isinstance(given.get("cdata"), np.ndarray) and hasattr(artist, "set_data"):
        artist.set_data(given["cdata"])
    if hasattr(artist, "get_xaxis"):
        for key, value in given.items():
            _set_axis(artist, key, value)


def _set_data(artist: Any, data: list[Any]) -> None:
    if hasattr(artist, "get_data_3d"):
        artist.set_data_3d(*(now if new is None else new for now, new in zip(artist.get_data_3d(), data, strict=True)))
    elif hasattr(artist, "set_xdata"):
        for method, new in zip(("set_xdata", "set_ydata"), data, strict=False):
            if new is not None:
                getattr(artist, method)(new)
        # Between two calls of set one of them may be longer.
        if len(artist.get_xdata()) != len(artist.get_ydata()):
            return
    elif hasattr(artist, "set_xy") and data[0] is not None and data[1] is not None:
        artist.set_xy(np.column_stack(data[:2]))
    if (axes := artist.axes) is not None and axes.name != "3d":
        axes.relim()
        axes.autoscale_view()


def _set_axis(axes: Any, key: str, value: Any) -> None:
    """Set a property of one axis: its limits, ticks, scale, direction or grid."""
    name, part = key[:1], key[1:]
    if name not in "xyz" or not hasattr(axes, f"set_{name}lim"):
        return
    if part == "lim" and isinstance(value, np.ndarray):
        getattr(axes, f"set_{name}lim")(*np.ravel(value))
    elif part == "tick" and isinstance(value, np.ndarray):
        set_ticks(axes, f"set_{name}ticks", np.ravel(value).tolist())
    elif part == "ticklabel" and isinstance(value, list | np.ndarray):
        set_ticks(axes, f"set_{name}ticklabels", value if isinstance(value, list) else np.ravel(value).tolist())
    elif part == "scale" and value in ("log", "linear"):
        getattr(axes, f"set_{name}scale")(value)
    elif part == "color" and axes.name != "3d":
        color = properties_of(["color", value]).get("color") or "black"
        axes.tick_params(axis=name, colors=color)
        getattr(axes, f"{name}axis").label.set_color(color)
    elif part == "dir" and value == "reverse":
        getattr(axes, f"set_{name}lim")(*getattr(axes, f"get_{name}lim")()[::-1])
    elif part == "grid" and value in ("on", "off"):
        axes.grid(visible=value == "on", axis=name, alpha=0.4)


def set_ticks(axes: Any, method: str, values: list[Any]) -> None:
    """Set ticks, or their labels; labels without ticks stand at 1, 2, ..."""
    if method.endswith("labels"):
        values = [math_text(each) if isinstance(each, str) else f"{float(np.ravel(each)[0]):g}" for each in values]
        ticks = method.replace("labels", "s")
        found = getattr(axes, ticks.replace("set", "get"))()
        values = values or [""] * len(found)
        if not any(values):
            getattr(axes, ticks)(found)
        elif len(found) != len(values):
            getattr(axes, ticks)(np.arange(1.0, len(values) + 1))
    getattr(axes, method)(values)
