"""Studies of the workplaces of a world: what each seated person reaches, sees and touches."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import mujoco
import numpy as np

from mjsim.compile import compile_world, compiled
from mjsim.ergonomics.clearance import Clearance, clearances, collisions
from mjsim.ergonomics.reach import Envelope, TargetReach, reach_envelope, settled, target_reach
from mjsim.ergonomics.sight import DisplayView, Eye, eyes_of, view_of
from mjsim.errors import UsageError
from mjsim.geometry import Array
from mjsim.people import SEXES, SIDES, Figure, Measures
from mjsim.posture import Seated, Sitter, Workstation, comfort_of, posture_angles, seated
from mjsim.world import DisplayTarget, Person, World

PERCENTILES = (5.0, 50.0, 95.0)
"""Percentiles of stature for which the travel of a seat is evaluated."""
SEAT_SEARCH_RANGE = 1.0
"""Range in which the ideal seat position is searched [m]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SeatSetting:
    """Seat setting for a figure of the survey."""

    sex: str
    percentile: float
    set_by: tuple[float, float]
    """Setting relative to the middle of the travel, along and up, limited to the travel [m]."""
    ideal: tuple[float, float]
    """Ideal hip point without this limit [m]."""
    missed: tuple[str, ...]
    """Contacts out of reach within the travel."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PersonStudy:
    """A person at a workplace."""

    model: mujoco.MjModel
    """The compiled world."""
    person: Person
    place: Workstation
    seated: Seated
    poses: Mapping[str, Array]
    """world_from_segment, shape (4, 4) each [m]."""
    angles: Mapping[str, float]
    """Angles of the posture [deg]."""
    reaches: Sequence[TargetReach]
    views: Mapping[str, DisplayView]
    """Visible parts of displays, by display."""
    clearances: Sequence[Clearance]
    collisions: Sequence[Clearance]
    """Collisions of the posture with objects."""
    settings: Sequence[SeatSetting]
    envelopes: Sequence[Envelope]
    eyes: tuple[Eye, Eye]


def studies(world: World) -> list[PersonStudy]:
    """Return a study of each seated person of a world.

    Raises:
        UsageError: Nobody is seated in it.
    """
    sitting = [person for person in world.people if person.seat is not None]
    if not sitting:
        raise UsageError("no person in this world is seated; give one seat: THING, and the thing a seat")
    model = compiled(compile_world(world))
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    return [_study(world, person, model, data) for person in sitting]


def _study(world: World, person: Person, model: mujoco.MjModel, data: mujoco.MjData) -> PersonStudy:
    place, figure, posture = Workstation.of(world, person), person.figure, seated(world, person)
    poses = figure.poses(posture.values, posture.world_from_pelvis)
    still = Sitter(figure, settled(place.seating, posture))
    reaches = [target_reach(still, place.goals, each) for each in place.targets.values()]
    eyes = eyes_of(figure, poses, gaze=place.goals.gaze)
    head = model.body(f"{person.name}/head").id
    room = clearances(model, data, person.name)
    displays = {name: each for name, each in place.targets.items() if isinstance(each.target, DisplayTarget)}
    return PersonStudy(
        model=model,
        person=person,
        place=place,
        seated=posture,
        poses=poses,
        angles=posture_angles(figure, poses),
        reaches=[reach for reach in reaches if reach is not None],
        views={name: view_of(model, data, eyes, each, head=head) for name, each in displays.items()},
        clearances=room,
        collisions=collisions(room, person),
        settings=seat_settings(place),
        envelopes=[reach_envelope(still, place.goals, side) for side in SIDES],
        eyes=eyes,
    )


def seat_settings(place: Workstation, percentiles: Sequence[float] = PERCENTILES) -> list[SeatSetting]:
    """Return the settings of a seat for women and men at percentiles of stature, with the tasks of its person."""
    found = []
    along, up = (SEAT_SEARCH_RANGE if length > 0.0 else 0.0 for length in place.seating.travel)
    free = replace(place.seating, travel=(along, up))
    for sex in SEXES:
        for percentile in percentiles:
            figure = Figure.of(Measures.at_percentile(sex, percentile))
            within = Sitter(figure, place.seating).sit(place.goals)
            ideal = Sitter(figure, free).sit(place.goals)
            found.append(
                SeatSetting(
                    sex=sex,
                    percentile=percentile,
                    set_by=within.set_by,
                    ideal=ideal.set_by,
                    missed=within.missed,
                )
            )
    return found


def figures_of(study: PersonStudy) -> dict[str, Any]:
    """Return the results of a study, as in its JSON file."""
    person, posture = study.person, study.seated
    joints = zip(person.figure.joints, np.degrees(posture.values).tolist(), strict=True)
    return {
        "person": person.name,
        "sex": person.sex,
        "seat": person.seat,
        "stature_m": person.figure.measures["stature"],
        "seat_set_by_m": list(posture.set_by),
        "angles_deg": {
            name: {"value": value, "published": [_range(each) for each in comfort_of(name)]}
            for name, value in study.angles.items()
        },
        "joints_deg": dict(joints),
        "contacts": {name: contact_figure(name, error) for name, error in posture.errors.items()},
        "missed": list(posture.missed),
        "reach": {
            each.target: {"limb": each.limb, "short_m": each.short, "short_leaning_m": each.leaning}
            for each in study.reaches
        },
        "displays": {
            name: {
                "visible": dict(view.shares),
                "hidden_by": dict(view.hidden_by),
                "distance_m": view.distance,
                "incidence_deg": view.incidence_deg,
            }
            for name, view in study.views.items()
        },
        "clearances": [_clearance_json(each) for each in study.clearances],
        "collisions": [_clearance_json(each) for each in study.collisions],
        "seat_travel": [_setting_json(each) for each in study.settings],
        "envelopes": {
            each.side: {"shoulder": each.shoulder.tolist(), "points": _or_none(each.points)} for each in study.envelopes
        },
    }


def contact_figure(name: str, error: float) -> dict[str, float]:
    """Return the error of a contact with its unit in the key: the gaze is a direction, the others are distances."""
    return {"error_deg": math.degrees(error)} if name == "gaze" else {"error_mm": 1000.0 * error}


def _setting_json(setting: SeatSetting) -> dict[str, Any]:
    return {
        "sex": setting.sex,
        "percentile": setting.percentile,
        "set_by_m": list(setting.set_by),
        "wished_m": list(setting.ideal),
        "missed": list(setting.missed),
    }


def _clearance_json(clearance: Clearance) -> dict[str, Any]:
    return {"segment": clearance.segment, "thing": clearance.thing, "distance_m": clearance.distance}


def _range(comfort: Any) -> dict[str, Any]:
    return {"low": comfort.low, "high": comfort.high, "source": comfort.source}


def _or_none(points: Array) -> list[list[list[float] | None]]:
    """Return points, with None for missing ones."""
    return [[None if np.isnan(point).any() else point.tolist() for point in row] for row in points]
