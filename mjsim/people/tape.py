"""Measures a figure as in the survey: standing, sitting erect and reaching.

References:
    Hotzman et al., Measurer's Handbook: US Army and Marine Corps Anthropometric Surveys, NATICK/TR-11/017 (2011).
"""

import math
from collections.abc import Mapping

import numpy as np

from mjsim.geometry import Array
from mjsim.people.figure import Figure

_RIGHT_ANGLE = math.pi / 2
SITTING: Mapping[str, float] = {
    f"{side}_{joint}": _RIGHT_ANGLE for side in ("left", "right") for joint in ("hip_flexion", "knee_flexion")
}
"""Horizontal thighs and vertical shanks [rad]."""


def measured(figure: Figure) -> dict[str, float]:
    """Return all measures of a figure, between its landmarks in the survey's postures [m; weight in kg]."""
    return {**_standing(figure), **_sitting(figure), **_of_arms(figure), **_of_parts(figure)}


def _standing(figure: Figure) -> dict[str, float]:
    """Return heights above the floor, standing [m]."""
    spots = figure.spots(figure.poses())
    floor = min(spots["left_heel"][2], spots["left_ball"][2])
    heights = {
        "stature": "vertex",
        "acromial_height": "left_acromion",
        "trochanterion_height": "left_trochanterion",
        "lateral_epicondyle_height": "left_lateral_epicondyle",
        "lateral_malleolus_height": "left_lateral_malleolus",
        "tibial_height": "left_tibiale",
        "cervicale_height": "cervicale",
        "suprasternale_height": "suprasternale",
        "iliocristale_height": "left_iliocristale",
    }
    return {name: float(spots[mark][2] - floor) for name, mark in heights.items()}


def _sitting(figure: Figure) -> dict[str, float]:
    """Return the measures of a person sitting erect, with elbows at right angles [m]."""
    bent = {**SITTING, "left_elbow_flexion": _RIGHT_ANGLE}
    spots = figure.spots(figure.poses(figure.values(bent)))
    seat, sole, buttock = spots["seat"][2], spots["left_sole"][2], spots["buttock"][0]
    return {
        "sitting_height": float(spots["vertex"][2] - seat),
        "eye_height_sitting": float(spots["left_eye"][2] - seat),
        "elbow_rest_height": float(spots["left_elbow_under"][2] - seat),
        "knee_height_sitting": float(spots["left_suprapatella"][2] - sole),
        "popliteal_height": float(spots["left_popliteal"][2] - sole),
        "buttock_knee_length": float(spots["left_knee"][0] - buttock),
        "buttock_popliteal_length": float(spots["left_popliteal"][0] - buttock),
        "forearm_hand_length": float(spots["left_fingertip"][0] - spots["left_elbow_behind"][0]),
        "hip_breadth_sitting": _distance(spots, "left_hip_side", "right_hip_side"),
    }


def _of_arms(figure: Figure) -> dict[str, float]:
    """Return lengths of hanging arms, forward reach from a wall behind the back, and span [m]."""
    hanging = figure.spots(figure.poses())
    forward = figure.spots(figure.poses(figure.values({"left_shoulder_flexion": _RIGHT_ANGLE})))
    abducted = {f"{side}_shoulder_abduction": _RIGHT_ANGLE for side in ("left", "right")}
    sideways = figure.spots(figure.poses(figure.values(abducted)))
    return {
        "upper_arm_length": float(hanging["left_acromion"][2] - hanging["left_radiale"][2]),
        "forearm_length": float(hanging["left_radiale"][2] - hanging["left_stylion"][2]),
        "hand_length": float(hanging["left_stylion"][2] - hanging["left_fingertip"][2]),
        "palm_length": float(hanging["left_stylion"][2] - hanging["left_palm_end"][2]),
        "thumb_tip_reach": float(forward["left_thumb_tip"][0] - forward["chest_back"][0]),
        "span": _distance(sideways, "left_fingertip", "right_fingertip"),
    }


def _of_parts(figure: Figure) -> dict[str, float]:
    spots = figure.spots(figure.poses())
    pairs = {
        "biacromial_breadth": ("left_acromion", "right_acromion"),
        "bideltoid_breadth": ("left_deltoid", "right_deltoid"),
        "bicristal_breadth": ("left_iliocristale", "right_iliocristale"),
        "head_breadth": ("left_euryon", "right_euryon"),
        "interpupillary_breadth": ("left_eye", "right_eye"),
    }
    depths = {
        "head_length": ("glabella", "occiput"),
        "chest_depth": ("chest_front", "chest_back"),
        "waist_depth": ("waist_front", "waist_back"),
        "foot_length": ("left_toe", "left_heel"),
    }
    sole_to_back = _leg_length(figure)
    return {
        **{name: _distance(spots, *pair) for name, pair in pairs.items()},
        **{name: float(spots[front][0] - spots[back][0]) for name, (front, back) in depths.items()},
        "tragion_to_vertex": float(spots["vertex"][2] - spots["left_tragion"][2]),
        "functional_leg_length": sole_to_back,
        "weight": sum(segment.solid.mass for segment in figure.segments.values()),
    }


def _leg_length(figure: Figure) -> float:
    """Return the distance from the sole of a stretched leg to the back of the waist, along the leg [m]."""
    spots = figure.spots(figure.poses(figure.values({"left_hip_flexion": _RIGHT_ANGLE})))
    return float(spots["left_sole"][0] - spots["buttock"][0])


def _distance(spots: Mapping[str, Array], first: str, second: str) -> float:
    return float(np.linalg.norm(spots[first] - spots[second]))
