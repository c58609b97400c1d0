"""Functions of MATLAB that write: titles, labels, texts, legends and scales of colours, by name."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from mjsim.toolbox.calls import FigureCall
from mjsim.toolbox.draw import Drawing, ScriptFigures
from mjsim.toolbox.marks import data_of, is_text, math_text, properties_of

PLACES = {"best": "best", "northeast": "upper right", "northwest": "upper left", "southeast": "lower right",
          "southwest": "lower left", "north": "upper center", "south": "lower center", "east": "center right",
          "west": "center left", "ne": "upper right", "nw": "upper left", "se": "lower right", "sw": "lower left",
          "bestoutside": "outside right upper"}  # fmt: skip
"""Places of a legend."""
OUTSIDE: Mapping[str, tuple[str, tuple[float, float]]] = {
    "north": ("lower center", (0.5, 1.02)), "south": ("upper center", (0.5, -0.12)),
    "east": ("center left", (1.02, 0.5)), "west": ("center right", (-0.12, 0.5)),
    "northeast": ("upper left", (1.02, 1.0)), "northwest": ("upper right", (-0.12, 1.0)),
    "southeast": ("lower left", (1.02, 0.0)), "southwest": ("lower right", (-0.12, 0.0)),
    "best": ("upper left", (1.02, 1.0)),
}  # fmt: skip
"""Places of a legend beside the axes: its corner, and where that is in the axes."""
NUMBERED = {-1: "northeastoutside", 0: "best", 1: "northeast", 2: "northwest", 3: "southwest", 4: "southeast"}
"""Places of a legend as numbers, as in old programs."""
OPTIONS = ("location", "orientation", "fontsize", "numcolumns", "interpreter", "box", "autoupdate", "textcolor",
           "color", "edgecolor", "fontweight", "fontname", "position", "units", "linewidth", "string")  # fmt: skip
"""Properties of a legend, in lower case."""


def _as_text(words: Any) -> str:
    """Return text that may be lines of a cell, or a number."""
    if isinstance(words, list):
        return "\n".join(map(_as_text, words))
    return words if is_text(words) else f"{float(np.ravel(words)[0]):g}" if np.size(words) else ""


def _written(words: Any, given: Sequence[Any]) -> str:
    """Return text as matplotlib writes it; without symbols if its interpreter is none."""
    text = _as_text(words)
    pairs = {key.lower(): value for key, value in zip(given[::2], given[1::2], strict=False) if is_text(key)}
    return text.replace("$", r"\$") if pairs.get("interpreter") == "none" else math_text(text)


def _label(method: str) -> Drawing:
    def labelling(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
        axes = drawn.pane(call.figure).axes
        if not hasattr(axes, method):
            return []
        words, rest = call.arguments[:1], call.arguments[1:]
        return [getattr(axes, method)(_written(words[0] if words else "", rest), **properties_of(rest))]

    return labelling


def _label_of(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
    """Return the title of axes, or the label of one of them."""
    handle, name = call.arguments
    axes = drawn.artists(float(np.ravel(handle)[0]))
    found = getattr(axes[0], "title" if name == "title" else f"{name[0]}axis", None) if axes else None
    return [] if found is None else [found if name == "title" else found.label]


def _main_title(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
    return [drawn.figure(call.figure).suptitle(_written(call.arguments[0], call.arguments[1:]))]


def _text(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
    """Write a text, or one at each of several points."""
    data = [np.ravel(each) for each in data_of(call)[:3]]
    words, rest = call.arguments[len(data)], call.arguments[len(data) + 1 :]
    axes = drawn.pane(call.figure).axes
    given, pairs = properties_of(rest), dict(zip(rest[::2], rest[1::2], strict=False))
    frame = {str(key).lower(): value for key, value in pairs.items()}
    if frame.keys() & {"backgroundcolor", "edgecolor"}:
        colors = properties_of(["facecolor", frame.get("backgroundcolor", "none"),
                                "edgecolor", frame.get("edgecolor", "none")])  # fmt: skip
        given["bbox"] = {"pad": 2.0, **colors}
        given.pop("edgecolor", None)
    if frame.get("units") == "normalized":
        given["transform"] = axes.transAxes
    count, made = max(len(each) for each in data), []
    for k in range(count):
        place = [*(float(each[min(k, len(each) - 1)]) for each in data), 0.0][: 3 if axes.name == "3d" else 2]
        own = words[min(k, len(words) - 1)] if isinstance(words, list) and count > 1 else words
        made.append(axes.text(*place, _written(own, rest), **given))
        # Axes keep their size beside a text far outside them.
        made[-1].set_in_layout(False)
    return made


def _legend(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
    pane = drawn.pane(call.figure)
    handles = [
        artist for each in data_of(call) for handle in np.ravel(each).tolist() for artist in drawn.artists(handle)
    ]
    words = [each for item in call.arguments for each in (item if isinstance(item, list) else [item])]
    at = next((k for k, each in enumerate(words) if is_text(each) and each.lower() in OPTIONS), len(words))
    options = {key.lower(): value for key, value in zip(words[at::2], words[at + 1 :: 2], strict=False) if is_text(key)}
    names = [each for each in words[:at] if is_text(each)]
    lower = [name.lower() for name in names]
    if lower in (["off"], ["hide"], ["boxoff"], ["boxon"]):
        named = [each for each in pane.labelled if not str(each.get_label()).startswith("_")]
        if lower[0] == "boxon" and pane.axes.get_legend() is None and named:
            # Formats as 'r;name;' give the names.
            return [pane.axes.legend(named, [math_text(str(each.get_label())) for each in named])]
        if (known := pane.axes.get_legend()) is not None:
            known.set_visible(lower[0] not in ("off", "hide"))
            known.set_frame_on(lower[0] != "boxoff")
        return []
    handles = handles or [each for each in pane.labelled or pane.axes.lines if _is_shown(each)]
    if lower in ([], ["show"]):
        names = [_name_of(each, k) for k, each in enumerate(handles, start=1)]
    numbers = [each for each in words[1:at] if isinstance(each, np.ndarray) and each.size == 1 and names]
    numbered = NUMBERED.get(int(numbers[-1].item())) if numbers else None
    place = str(options.get("location", numbered or "best")).lower()
    keywords: dict[str, Any] = {"loc": PLACES.get(place, "best")}
    if place.endswith("outside"):
        corner, keywords["bbox_to_anchor"] = OUTSIDE.get(place.removesuffix("outside"), OUTSIDE["best"])
        keywords["loc"] = corner
    count = min(len(handles), len(names))
    if options.get("orientation") == "horizontal":
        keywords["ncols"] = count
    elif "numcolumns" in options:
        keywords["ncols"] = int(np.ravel(options["numcolumns"])[0])
    keywords |= properties_of(["fontsize", options["fontsize"]]) if "fontsize" in options else {}
    keywords["frameon"] = options.get("box") != "off"
    flat = [f"{key}" for key in ("interpreter", options.get("interpreter", "tex"))]
    shown = [_written(name, flat) for name in names[:count]]
    return [pane.axes.legend(handles[:count], shown, **keywords)]


def _is_shown(artist: Any) -> bool:
    return not getattr(artist, "mjsim_hidden", False)


def _name_of(artist: Any, number: int) -> str:
    label = str(artist.get_label())
    return f"data{number}" if label.startswith("_") else label


def _colorbar(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
    pane = drawn.pane(call.figure)
    drawings = [*pane.axes.images, *pane.axes.collections]
    edges = {getattr(each, "mjsim_edges", None) for each in drawings}
    scales = [getattr(each, "mjsim_scale", each) for each in drawings if each not in edges]
    mapped = [each for each in scales if each.get_array() is not None or each not in drawings]
    if not mapped:
        return []
    place = next((each.lower().removesuffix("outside") for each in call.arguments if is_text(each)), "east")
    side = {"north": "top", "south": "bottom", "west": "left"}.get(place, "right")
    return [drawn.figure(call.figure).colorbar(mapped[-1], ax=pane.axes, location=side).ax]


TEXT_FUNCTIONS: Mapping[str, Drawing] = {
    "title": _label("set_title"),
    "xlabel": _label("set_xlabel"),
    "ylabel": _label("set_ylabel"),
    "zlabel": _label("set_zlabel"),
    "label_of": _label_of,
    "sgtitle": _main_title,
    "suptitle": _main_title,
    "text": _text,
    "legend": _legend,
    "colorbar": _colorbar,
}
"""Functions that draw, by the names of their calls."""
