"""Recordings in JSON for the page: downsampled overview, and single ticks."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from mjsim.geometry import Array, Pose
from mjsim.record import Recording, Track
from mjsim.report import metrics
from mjsim.web.run import (
    NO_NEES,
    EventNews,
    JointRow,
    RobotTick,
    SensorPast,
    TickNews,
    TrackHistory,
    drawn_bodies,
    joint_rows,
    joints_json,
    outlines_json,
    people_json,
    plain,
    recognised_json,
    robots_json,
    row_of,
    shown_json,
    track_json,
    with_removed,
)
from mjsim.world import EVENT_KINDS, as_motions, event_text, kind_of

MAX_ROWS = 5000
"""Maximum number of rows of a track."""
People = Mapping[str, Sequence[tuple[Array, str]]]
"""Outlines from above of people by name, with their colours, world frame, shape (n, 2) each [m]."""
PACED_OVER = 1.0
"""Time over which the pace of a recorded run is measured [s]."""
WHOLE = "frame"
"""The film view that combines plan, close-up, camera and error."""


def recording_json(recording: Recording, *, path: str, scene: Mapping[str, Any]) -> dict[str, Any]:
    """Return the overview of a recording in JSON form; `scene` contains the plan of its world."""
    cameras = ["/".join(camera) for camera in recording.cameras()]
    return {
        "path": path,
        "bytes": recording.path.stat().st_size,
        "name": recording.world.name,
        "robots": robots_json(recording.world),
        "seconds": float(recording.time[-1]),
        "begin": float(recording.time[0]),
        "dt": 1.0 / recording.world.run.rate_hz,
        "ticks": len(recording.time),
        "whole": recording.whole,
        "seed": recording.seed,
        "metadata": dict(recording.metadata),
        "scene": scene,
        "tracks": {name: _track(recording, name) for name, track in recording.robots.items() if _driven(track)},
        "events": events_json(recording),
        "cameras": cameras,
        "views": [WHOLE, "plan", "chase", "overview", *cameras],
        "has_states": recording.qpos.shape[1] > 0,
        "joints": joints_json(recording.world),
    }


def row_at(recording: Recording, time: float) -> int:
    """Return the index of the last tick not after a time [s]; 0 if all are later."""
    return row_of(recording.time, time)


@np.errstate(over="ignore", invalid="ignore")  # an estimate may be anywhere
def row_json(
    recording: Recording, row: int, *, measured: SensorPast | None = None, people: People | None = None
) -> TickNews:
    """Return a recorded tick in the JSON form of a live one.

    Args:
        recording: The recording.
        row: Index of the tick.
        measured: Sensor readings; by default left out.
        people: Outlines from above of people whose hands were moved, with their colours.
    """
    first = row_at(recording, float(recording.time[row]) - PACED_OVER)
    took = float(recording.clock[row] - recording.clock[first])
    robots = {
        name: _robot(recording, name, row=row, measured=measured)
        for name, track in recording.robots.items()
        if np.isfinite(track.estimate[row]).all()
    }
    tick: TickNews = {
        "kind": "tick",
        "number": row,
        "time": float(recording.time[row]),
        "pace": plain((recording.time[row] - recording.time[first]) / took, 3) if took > 0.0 else 0.0,
        "robots": robots,
        "things": {
            name: plain(places[row]) for name, places in recording.things.items() if np.isfinite(places[row]).all()
        },
    }
    if people:
        tick["people"] = people_json(people)
    if recording.joints:
        tick["joints"], tick["bodies"] = _joints(recording, row)
    return with_removed(tick, recording.looks(row))


def _joints(
    recording: Recording, row: int
) -> tuple[dict[str, dict[str, JointRow]], dict[str, list[list[tuple[float, float]]]]]:
    """Return the motion of joints, and outlines of what they carry."""
    tracks = recording.joints
    rows = {
        name: joint_rows(track.names, track.positions[row], track.velocities[row], track.torques[row])
        for name, track in tracks.items()
    }
    truths = {name: track.truth[row] for name, track in recording.robots.items()}
    places = {name: Pose.from_array(truth) for name, truth in truths.items() if np.isfinite(truth).all()}
    values = {name: track.positions[row] for name, track in tracks.items()}
    return rows, outlines_json(drawn_bodies(recording.world, values, places))


def events_json(recording: Recording) -> list[EventNews]:
    """Return all events of robots and the world, in order of time."""
    events: list[EventNews] = [
        {"kind": "event", "time": event.time, "robot": name, "event": event.kind, "text": event.text}
        for name, track in recording.robots.items()
        for event in track.events
    ]
    for happened in as_motions(recording.events):
        kind = str(kind_of(happened, EVENT_KINDS))
        events.append(
            {"kind": "event", "time": happened.time, "robot": None, "event": kind, "text": event_text(happened)}
        )
    return sorted(events, key=lambda event: event["time"])


def default_film(path: str, *, view: str, begin: float, end: float) -> Path:
    """Return the default output file of a film, below the folder of the studio."""
    called = f"{Path(path).parent.name}-{Path(path).stem}" if Path(path).parent.name else Path(path).stem
    return Path("out") / "films" / f"{called}-{view.replace('/', '-')}-{begin:g}-{end:g}s.mp4"


def _driven(track: Track) -> bool:
    return bool(np.isfinite(track.estimate).all(axis=1).any())


def _track(recording: Recording, name: str) -> TrackHistory:
    track = recording.robots[name]
    keep = slice(None, None, max(1, math.ceil(len(track.time) / MAX_ROWS)))
    covariance = track.covariance.reshape(-1, 9)
    return track_json(
        track.time[keep],
        truth=track.truth[keep],
        estimate=track.estimate[keep],
        odometry=track.odometry[keep],
        covariance=covariance[keep],
        timing={part: seconds[keep] for part, seconds in _timing(recording, name).items()},
        estimated=recording.has_estimator(name),
    )


def _timing(recording: Recording, robot: str) -> dict[str, Array]:
    """Return the duration of each module of a robot and each part of the loop, shape (N,) [s]."""
    parts = ("loop/", f"{robot}/")
    return {
        name.partition("/")[2]: seconds for name, seconds in recording.module_seconds.items() if name.startswith(parts)
    }


def _robot(recording: Recording, name: str, *, row: int, measured: SensorPast | None) -> RobotTick:
    track = recording.robots[name]
    truth, estimate, P = track.truth[row], track.estimate[row], track.covariance[row]
    marks = track.landmarks
    mapped = [k for k in range(len(marks.names)) if np.isfinite(marks.mean[row, k]).all()]
    estimated = recording.has_estimator(name)
    nees = metrics.normalised_errors(truth[None], estimate[None], P[None]) if estimated else NO_NEES
    timing = {part: float(1e3 * seconds[row]) for part, seconds in _timing(recording, name).items()}
    robot_tick: RobotTick = {
        "truth": plain(truth),
        "estimate": plain(estimate),
        "odometry": plain(track.odometry[row]),
        "covariance": plain(P.ravel(), 9),
        "landmarks": {
            str(marks.names[k]): plain(
                [*marks.mean[row, k], *marks.covariance[row, k][np.triu_indices(2)]],
                6,
            )
            for k in mapped
        },
        "sightings": [(each.name, round(each.range, 4), round(each.bearing, 5)) for each in track.sightings[row]],
        "recognised": recognised_json(track.sightings[row]),
        "error": plain(metrics.position_errors(truth[None], estimate[None]), 5)[0],
        "heading_error": plain(metrics.heading_errors(truth[None], estimate[None]), 5)[0],
        "nees": plain(nees, 3)[0],
        "estimated": estimated,
        "timing": {part: round(ms, 3) for part, ms in timing.items() if math.isfinite(ms)},
        "command": plain(track.command[row]),
    }
    if track.shown and track.shown[row]:
        robot_tick["show"] = shown_json(track.shown[row])
    if measured is not None:
        measured.add_to(robot_tick, name, row)
    return robot_tick
