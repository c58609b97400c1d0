"""The plots of a report as axes of pyplot, which notebooks show and scripts extend."""

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import pyplot
from numpy.typing import NDArray

from mjsim.errors import UsageError, did_you_mean
from mjsim.record import Recording
from mjsim.report import robot_plots

if TYPE_CHECKING:
    from matplotlib.axes import Axes


KINDS = ("path", "error", "bounds", "nees", "landmarks")


def plotted(recording: Recording, kind: str, *, robot: str | None = None) -> "Axes | NDArray[Any]":
    """Return the axes of a plot; `Recording.plot` describes the arguments.

    Raises:
        UsageError: There is no such plot or robot, or nothing to draw.
    """
    name = chosen(recording, robot)
    if kind not in KINDS:
        raise UsageError(f"no plot '{kind:.40}' of a recording{did_you_mean(kind, KINDS)}")
    figure = robot_plots(recording, name, only=kind).get(kind)
    if figure is None:
        raise UsageError(f"there is nothing to draw as '{kind}' of robot '{name}'")
    pyplot.figure(figure)
    panels = np.array(figure.axes, dtype=object)
    axes: Axes | NDArray[Any] = panels[0] if len(panels) == 1 else panels
    return axes


def chosen(recording: Recording, robot: str | None) -> str:
    """Return the name of a robot of a recording, by default the first.

    Raises:
        UsageError: It has no such robot.
    """
    if not recording.robots:
        raise UsageError(f"'{recording.path}' has no robots")
    name = next(iter(recording.robots)) if robot is None else robot
    if name not in recording.robots:
        raise UsageError(f"no robot '{name:.40}' in '{recording.path}'{did_you_mean(name, recording.robots)}")
    return name
