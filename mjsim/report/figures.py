"""The statistics shown in tables: title, unit, and which direction is better."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from mjsim.report.consistency import NO_ESTIMATOR


@dataclass(frozen=True, slots=True)
class ReportFigure:
    """One number of a robot in `statistics.json`."""

    key: str
    """Its key, such as 'position_error_m.mean'."""
    title: str
    unit: str = ""
    digits: int = 3
    """Number of decimals in tables."""
    better: Literal["lower", "higher", ""] = "lower"
    """Which direction is better; empty if neither is."""
    odometry: str = ""
    """Key of the same statistic for dead reckoning."""

    @property
    def heading(self) -> str:
        """Title and unit, as in a row of a table."""
        return f"{self.title} [{self.unit}]" if self.unit else self.title

    def text(self, value: float | None) -> str:
        """Return a value as shown in tables; '-' for a missing one."""
        return "-" if value is None else f"{value:.{self.digits}f}"


FIGURES = (
    ReportFigure("position_error_m.mean", "position error, mean", "m", odometry="odometry_error_m.mean"),
    ReportFigure("position_error_m.rmse", "position error, rmse", "m", odometry="odometry_error_m.rmse"),
    ReportFigure("position_error_m.max", "position error, largest", "m", odometry="odometry_error_m.max"),
    ReportFigure("position_error_m.final", "position error, at the end", "m", odometry="odometry_error_m.final"),
    ReportFigure("heading_error_deg.mean", "heading error, mean", "deg", 2, odometry="odometry_heading_error_deg.mean"),
    ReportFigure("ate_m.rmse", "ATE, rmse", "m", odometry="odometry_ate_m.rmse"),
    ReportFigure("rpe_m.rmse", "RPE over 1 m, rmse", "m", odometry="odometry_rpe_m.rmse"),
    ReportFigure("path_error_m.mean", "final path: position error, mean", "m"),
    ReportFigure("path_error_m.rmse", "final path: position error, rmse", "m"),
    ReportFigure("path_heading_error_deg.mean", "final path: heading error, mean", "deg", 2),
    ReportFigure("path_ate_m.rmse", "final path: ATE, rmse", "m"),
    ReportFigure("path_rpe_m.rmse", "final path: RPE over 1 m, rmse", "m"),
    ReportFigure("nees.mean", "NEES, mean (3 expected)", "", 2, ""),
    ReportFigure("nees.in_band", "NEES in its 95 % band, share", "", 2, ""),
    ReportFigure("nis.mean", "NIS, mean (2 expected)", "", 2, ""),
    ReportFigure("nis.in_band", "NIS in its 95 % band, share", "", 2, ""),
    ReportFigure("landmark_error_m.count", "landmarks in the map", "", 0, ""),
    ReportFigure("landmark_error_m.rms", "landmark error, rms", "m"),
    ReportFigure("landmark_error_m.aligned_rms", "landmark error, aligned rms", "m"),
    ReportFigure("distance_m", "distance driven", "m", 1, ""),
    ReportFigure("coverage", "coverage, share of cells touched", "", 2, "higher"),
    ReportFigure("coverage_area", "coverage, share of area swept", "", 2, "higher"),
    ReportFigure("bumps", "bumps", "", 0),
    ReportFigure("falls", "falls", "", 0),
)
"""Statistics in the order of the rows of a table."""


def largest(key: str) -> float:
    """Return the maximum of a statistic; the minimum is 0."""
    return 1.0 if key in ("coverage", "coverage_area") or key.endswith(".in_band") else math.inf


def lacks_estimator(robot: Mapping[str, Any]) -> bool:
    """Return whether a robot's statistics are those of dead reckoning alone."""
    return (robot.get("nees") or {}).get("reason") == NO_ESTIMATOR


def figure_value(robot: Mapping[str, Any], key: str) -> float | None:
    """Return the number under a key such as 'nees.mean' of a robot's statistics; None if there is none to show.

    The NEES of dead reckoning is not shown: no estimator claims its covariance.
    """
    if key.startswith("nees.") and lacks_estimator(robot):
        return None
    value: Any = robot
    for part in key.split("."):
        if not isinstance(value, Mapping):
            return None
        value = value.get(part)
    return float(value) if isinstance(value, (int, float)) else None
