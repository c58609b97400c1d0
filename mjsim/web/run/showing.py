"""Items shown by estimators, in JSON form."""

import base64
from collections.abc import Sequence

from mjsim.interface import Shown, ShownGrid, ShownLines, ShownPoints, ShownText
from mjsim.record import grid_png
from mjsim.web.run.measured import flat_points
from mjsim.web.run.news import ShownNews


def shown_json(items: Sequence[Shown]) -> list[ShownNews]:
    """Return shown items in JSON form; their numbers are in the frame that each names."""
    return [_item_json(item) for item in items]


def _item_json(item: Shown) -> ShownNews:
    content: ShownNews = {"name": item.name, "frame": item.frame, "color": item.color}
    if isinstance(item, ShownPoints):
        content |= {"points": flat_points(item.points), "size": item.size}
    elif isinstance(item, ShownLines):
        content |= {"lines": flat_points(item.points), "joined": item.joined, "size": item.width}
    elif isinstance(item, ShownText):
        content |= {"text": item.text, "points": flat_points(item.at)}
    elif isinstance(item, ShownGrid):
        rows, columns = item.cells.shape
        content |= {
            "png": base64.b64encode(grid_png(item)).decode(),
            "size": item.resolution,
            "origin": (item.origin.x, item.origin.y, item.origin.heading),
            "cells": (columns, rows),
        }
    return content
