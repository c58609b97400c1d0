"""A report as files: `statistics.json`, the plots as PNG, and one HTML page that opens offline."""

import base64
import html
import io
import json
from pathlib import Path
from typing import Any

import numpy as np

from mjsim.errors import UsageError
from mjsim.record import Recording
from mjsim.report.statistics import statistics_file
from mjsim.world.events import said_of

STYLE = """
:root { color-scheme: light dark; --ink: #1c1c1c; --paper: #fdfdfb; --soft: #6b6b6b; --line: #ddddd8; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e8e8e4; --paper: #1b1c1e; --soft: #a5a5a0; --line: #3a3b3e; }
}
body { font: 16px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--paper); max-width: 60rem;
  margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.6rem; margin-bottom: 0; } h2 { font-size: 1.2rem; margin-top: 2.5rem; }
p.run { color: var(--soft); margin-top: 0.2rem; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th, td { text-align: right; padding: 0.3rem 0.6rem; border-bottom: 1px solid var(--line); }
th:first-child, td:first-child { text-align: left; }
thead th { color: var(--soft); font-weight: 500; }
img { width: 100%; height: auto; margin: 1rem 0; background: #fff; border-radius: 6px; }
"""


def write_report(recording: Recording, folder: Path) -> dict[str, Any]:
    """Write statistics, plots and page into a folder, made if need be; return what `statistics.json` holds.

    Raises:
        UsageError: The folder cannot be written.
    """
    figures = statistics_file(recording)
    files = _files(recording, figures)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, data in files.items():
            (folder / name).write_bytes(data)
    except OSError as error:
        raise UsageError(f"cannot write '{folder}': {error.strerror}") from error
    return figures


def _files(recording: Recording, figures: dict[str, Any]) -> dict[str, bytes]:
    """Return what is written, by the names of the files."""
    from mjsim.report.plots import PLOTS

    files = {"statistics.json": (json.dumps(figures, indent=1) + "\n").encode()}
    sections = []
    for robot, track in recording.robots.items():
        pictures = []
        for name, draw in PLOTS if np.isfinite(track.estimate).all() else ():
            buffer = io.BytesIO()
            draw(recording.world, track).savefig(buffer, format="png")
            files[f"{robot}_{name}.png"] = buffer.getvalue()
            pictures.append((name, buffer.getvalue()))
        sections.append(_section(robot, figures["robots"][robot], pictures))
    files["report.html"] = _page(recording, figures["run"], sections).encode()
    return files


def key_figures(robot: dict[str, Any]) -> list[tuple[str, str, str]]:
    """Return the rows of the small table of one robot: what, of the estimate, of dead reckoning."""
    if robot["position_error_m"] is None:
        return [("distance driven [m]", _number(robot["distance_m"], 1), ""), ("bumps", str(robot["bumps"]), "")]
    estimate, odometry = robot["position_error_m"], robot["odometry_error_m"]
    landmarks = robot["landmark_error_m"]
    return [
        ("position error, mean [m]", _number(estimate["mean"]), _number(odometry["mean"])),
        ("position error, largest [m]", _number(estimate["max"]), _number(odometry["max"])),
        ("position error, at the end [m]", _number(estimate["final"]), _number(odometry["final"])),
        ("heading error, mean [deg]", _number(robot["heading_error_deg"]["mean"], 2), ""),
        ("ATE, rmse [m]", _number(robot["ate_m"]["rmse"]), ""),
        ("RPE over 1 m, rmse [m]", _number(robot["rpe_m"]["rmse"]), ""),
        ("NEES, mean (3 expected)", _number(robot["nees"]["mean"], 2), ""),
        ("NIS, mean (2 expected)", _number(robot["nis"]["mean"], 2), ""),
        ("landmarks in the map", str(landmarks["count"]), ""),
        ("landmark error, aligned rms [m]", _number(landmarks["aligned_rms"]), ""),
        ("distance driven [m]", _number(robot["distance_m"], 1), ""),
        ("coverage", "" if robot["coverage"] is None else f"{robot['coverage']:.0%}", ""),
        ("bumps", str(robot["bumps"]), ""),
    ]


def key_table(figures: dict[str, Any]) -> list[str]:
    """Return the key figures of each robot as lines for a terminal, from what `statistics.json` holds."""
    lines = []
    for name, robot in figures["robots"].items():
        lines.append(f"{name:<34}{'estimate':>10}{'odometry':>10}")
        lines += [
            f"  {what:<32}{estimate:>10}{odometry:>10}".rstrip() for what, estimate, odometry in key_figures(robot)
        ]
    factor = figures["run"]["real_time_factor"]
    if factor is not None:
        lines.append(f"{'real-time factor of the run':<34}{factor:>10.1f}")
    return lines


def _number(value: float | None, digits: int = 3) -> str:
    return "-" if value is None else f"{value:.{digits}f}"


def _section(robot: str, figures: dict[str, Any], pictures: list[tuple[str, bytes]]) -> str:
    rows = "".join(
        f"<tr><td>{html.escape(what)}</td><td>{estimate}</td><td>{odometry}</td></tr>"
        for what, estimate, odometry in key_figures(figures)
    )
    images = "".join(
        f'<img alt="{name} of {html.escape(robot)}" src="data:image/png;base64,{base64.b64encode(png).decode()}">'
        for name, png in pictures
    )
    return (
        f"<h2>{html.escape(robot)}</h2><table><thead><tr><th></th><th>estimate</th><th>odometry</th></tr></thead>"
        f"<tbody>{rows}</tbody></table>{images}"
    )


def _page(recording: Recording, run: dict[str, Any], sections: list[str]) -> str:
    name = html.escape(recording.world.name)
    factor = "" if run["real_time_factor"] is None else f", {run['real_time_factor']:.1f} times real time"
    happened = "".join(
        f"<tr><td>{html.escape(said_of(event))}</td><td>{event.time:.2f} s</td></tr>" for event in recording.events
    )
    story = f"<h2>What happened to the world</h2><table><tbody>{happened}</tbody></table>" if happened else ""
    about = f"{run['sim_seconds']:.1f} s simulated{factor}, seed {run['seed']}"
    return (
        f'<!doctype html><html lang="en"><meta charset="utf-8"><title>{name} - mjsim report</title>'
        f'<meta name="viewport" content="width=device-width"><style>{STYLE}</style>'
        f'<h1>{name}</h1><p class="run">{about}</p>{"".join(sections)}{story}</html>\n'
    )
