"""Positions of the joints and landmarks of a standing body, from its measures.

The body stands upright on the floor, above the origin; x forward, y left, z up. Each measure is the distance between
landmarks in the posture of the survey, standing or sitting erect with horizontal thighs and vertical shanks.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from mjsim.people.deleva import TRUNK_LEVELS
from mjsim.people.measures import MeasureError, Measures
from mjsim.people.survey import Sex
from mjsim.sentences import Sentence

Vector3 = tuple[float, float, float]

SHOULDER_BELOW: Mapping[Sex, float] = {"female": 0.170, "male": 0.152}
"""Distance of the shoulder joint below the acromion, as a fraction of the length from acromion to radiale: it makes the
upper arm as long as de Leva's (1996, table 2) for the stature of his sample."""
SHOULDER_INWARD = 0.025
"""Distance of the shoulder joint from the tip of the acromion: about the radius of the humeral head [m]; assumed."""
HALF_HIPS = 0.31
"""Half the distance between the hip joints, as a fraction of bicristal breadth: 0.36 of the distance between the
anterior iliac spines (Bell et al., Human Movement Science 8, 1989), which is taken as 0.86 of that breadth (assumed).
"""
KNEE_FRONT = 0.6
"""Fraction of the depth of the bent knee, from its hollow to its front, that is in front of the joint; assumed."""
ANKLE_FROM_HEEL = 0.26
"""As a fraction of foot length; assumed."""
BALL_FROM_HEEL = 0.72
"""Distance of the ball of the foot from the heel, as a fraction of foot length; assumed."""
THUMB_TIP = 0.62
"""Distance from the wrist to the tip of the thumb when it touches the index finger, as a fraction of hand length;
assumed."""
GRIP_POSITION = 0.80
"""Distance from the wrist to the centre of the fist, as a fraction of palm length; assumed."""
SPINE_POSITION = 0.30
"""Distance of the joints of the spine from the back, as a fraction of the trunk's depth; assumed."""
PUPIL_BEHIND = 0.015
"""Distance of the pupils behind the glabella [m]; assumed."""
MIN_LENGTH = 0.005
"""Minimum length between landmarks [m]."""


@dataclass(frozen=True, slots=True)
class Spot:
    """A point on a standing body."""

    segment: str
    """The segment that contains it."""
    at: Vector3
    """World frame [m]."""


@dataclass(frozen=True, slots=True)
class BodyFrame:
    """Joints and landmarks of a standing body; for limbs those on the left."""

    joints: Mapping[str, Vector3]
    """Position of the joint above each segment, by segment, world frame [m]; for the pelvis, the H-point."""
    landmarks: Mapping[str, Spot]
    """By name; those of limbs, acromion and eyes are on the left."""
    seat_to_hip: float
    """Height of the hip joints above a hard seat, sitting erect [m]."""


def body_frame(measures: Measures) -> BodyFrame:
    """Return joints and landmarks of a standing body.

    Raises:
        MeasureError: No body has this combination of measures; the message names one that does not fit.
    """
    derived = _derived(measures)
    joints = _joints(measures, derived)
    return BodyFrame(joints, _landmarks(measures, derived, joints), derived["seat_to_hip"])


def _derived(m: Measures) -> dict[str, float]:
    """Return lengths derived from several measures [m]; raises MeasureError if one is not positive."""
    hip, knee = m["trochanterion_height"], m["lateral_epicondyle_height"]
    knee_depth = m["buttock_knee_length"] - m["buttock_popliteal_length"]
    upper_arm = (1.0 - SHOULDER_BELOW[m.sex]) * m["upper_arm_length"]
    sitting = m["sitting_height"] - m["stature"]
    found = {
        # name: (length, the measure to name if it is not valid)
        "thigh": (hip - knee, "lateral_epicondyle_height"),
        "shank": (knee - m["lateral_malleolus_height"], "lateral_malleolus_height"),
        "tibia": (knee - m["tibial_height"], "tibial_height"),
        "seat_to_hip": (hip + sitting, "sitting_height"),
        "knee_front": (KNEE_FRONT * knee_depth, "buttock_popliteal_length"),
        "knee_back": ((1.0 - KNEE_FRONT) * knee_depth, "buttock_popliteal_length"),
        "buttock": (m["buttock_knee_length"] - (hip - knee) - KNEE_FRONT * knee_depth, "buttock_knee_length"),
        "knee_above": (m["knee_height_sitting"] - knee, "knee_height_sitting"),
        "knee_below": (knee - m["popliteal_height"], "popliteal_height"),
        "upper_arm": (upper_arm, "upper_arm_length"),
        "back": (
            m["thumb_tip_reach"] - upper_arm - m["forearm_length"] - THUMB_TIP * m["hand_length"],
            "thumb_tip_reach",
        ),
        "elbow_below": (
            m["acromial_height"] + sitting - m["upper_arm_length"] - m["elbow_rest_height"],
            "elbow_rest_height",
        ),
        "elbow_behind": (m["forearm_hand_length"] - m["forearm_length"] - m["hand_length"], "forearm_hand_length"),
        "neck": (m["stature"] - m["cervicale_height"] - m["tragion_to_vertex"], "cervicale_height"),
        "eye_below_vertex": (m["sitting_height"] - m["eye_height_sitting"], "eye_height_sitting"),
        "crest": (m["iliocristale_height"] - hip, "iliocristale_height"),
        "sternum": (m["suprasternale_height"] - hip, "suprasternale_height"),
        "acromion": (m["acromial_height"] - hip, "acromial_height"),
        "palm": (m["hand_length"] - m["palm_length"], "palm_length"),
    }
    for length, measure in found.values():
        if length < MIN_LENGTH:
            raise MeasureError(
                measure,
                Sentence("{measure} is {m:.4g} m, which is impossible with the other measures", measure, m[measure]),
            )
    return {name: length for name, (length, _) in found.items()}


def _joints(m: Measures, derived: Mapping[str, float]) -> dict[str, Vector3]:
    hip, cervicale = m["trochanterion_height"], m["cervicale_height"]
    omphalion, xiphion = (hip + level * (cervicale - hip) for level in TRUNK_LEVELS[m.sex])
    back = -derived["back"]
    half_hips = HALF_HIPS * m["bicristal_breadth"]
    shoulder = (0.0, m["biacromial_breadth"] / 2 - SHOULDER_INWARD, m["acromial_height"])
    elbow = shoulder[2] - m["upper_arm_length"]
    return {
        "pelvis": (0.0, 0.0, hip),
        "abdomen": (back + SPINE_POSITION * m["waist_depth"], 0.0, omphalion),
        "thorax": (back + SPINE_POSITION * m["chest_depth"], 0.0, xiphion),
        "neck": (back + SPINE_POSITION * m["chest_depth"], 0.0, cervicale),
        "head": (
            back + SPINE_POSITION * m["chest_depth"] + 0.5 * derived["neck"],
            0.0,
            m["stature"] - m["tragion_to_vertex"],
        ),
        "left_upper_arm": (0.0, shoulder[1], elbow + derived["upper_arm"]),
        "left_forearm": (0.0, shoulder[1], elbow),
        "left_hand": (0.0, shoulder[1], elbow - m["forearm_length"]),
        "left_thigh": (0.0, half_hips, hip),
        "left_shank": (0.0, half_hips, m["lateral_epicondyle_height"]),
        "left_foot": (0.0, half_hips, m["lateral_malleolus_height"]),
    }


def _landmarks(m: Measures, derived: Mapping[str, float], joints: Mapping[str, Vector3]) -> dict[str, Spot]:
    return {**_of_trunk(m, derived, joints), **_of_arm(m, derived, joints), **_of_leg(m, derived, joints)}


def _of_trunk(m: Measures, derived: Mapping[str, float], joints: Mapping[str, Vector3]) -> dict[str, Spot]:
    hip, omphalion, xiphion = (joints[name][2] for name in ("pelvis", "abdomen", "thorax"))
    back, head = -derived["back"], joints["head"]
    glabella = head[0] + 0.55 * m["head_length"]
    eye = m["stature"] - derived["eye_below_vertex"]
    chest = 0.75 * xiphion + 0.25 * m["suprasternale_height"]
    return {
        "h_point": Spot("pelvis", (0.0, 0.0, hip)),
        "left_iliocristale": Spot("pelvis", (0.0, m["bicristal_breadth"] / 2, m["iliocristale_height"])),
        "left_trochanterion": Spot("pelvis", (0.0, 0.45 * m["hip_breadth_sitting"], hip)),
        "buttock": Spot("pelvis", (-derived["buttock"], 0.0, hip)),
        "seat": Spot("pelvis", (-0.3 * derived["buttock"], 0.0, hip - derived["seat_to_hip"])),
        "left_hip_side": Spot("pelvis", (0.0, m["hip_breadth_sitting"] / 2, hip)),
        "waist_back": Spot("abdomen", (back, 0.0, omphalion)),
        "waist_front": Spot("abdomen", (back + m["waist_depth"], 0.0, omphalion)),
        "chest_back": Spot("thorax", (back, 0.0, chest)),
        "chest_front": Spot("thorax", (back + m["chest_depth"], 0.0, chest)),
        "suprasternale": Spot("thorax", (back + 0.62 * m["chest_depth"], 0.0, m["suprasternale_height"])),
        "cervicale": Spot("thorax", (back + 0.06 * m["chest_depth"], 0.0, m["cervicale_height"])),
        "left_acromion": Spot("thorax", (0.0, m["biacromial_breadth"] / 2, m["acromial_height"])),
        "vertex": Spot("head", (head[0] + 0.05 * m["head_length"], 0.0, m["stature"])),
        "glabella": Spot("head", (glabella, 0.0, eye + 0.03)),
        "occiput": Spot("head", (glabella - m["head_length"], 0.0, eye + 0.02)),
        "left_tragion": Spot("head", (head[0], 0.47 * m["head_breadth"], m["stature"] - m["tragion_to_vertex"])),
        "left_euryon": Spot("head", (head[0], m["head_breadth"] / 2, eye + 0.04)),
        "left_eye": Spot("head", (glabella - PUPIL_BEHIND, m["interpupillary_breadth"] / 2, eye)),
    }


def _of_arm(m: Measures, derived: Mapping[str, float], joints: Mapping[str, Vector3]) -> dict[str, Spot]:
    x, y, elbow = joints["left_forearm"]
    wrist, hand = joints["left_hand"][2], m["hand_length"]
    return {
        "left_deltoid": Spot("left_upper_arm", (x, m["bideltoid_breadth"] / 2, elbow + 0.75 * derived["upper_arm"])),
        "left_radiale": Spot("left_upper_arm", (x, y + 0.04, elbow)),
        "left_elbow_under": Spot("left_forearm", (x - derived["elbow_below"], y, elbow)),
        "left_elbow_behind": Spot("left_forearm", (x, y, elbow + derived["elbow_behind"])),
        "left_stylion": Spot("left_forearm", (x + 0.027, y, wrist)),
        "left_palm_end": Spot("left_hand", (x, y, wrist - m["palm_length"])),
        "left_grip": Spot("left_hand", (x, y - 0.025, wrist - GRIP_POSITION * m["palm_length"])),
        "left_thumb_tip": Spot("left_hand", (x + 0.03, y, wrist - THUMB_TIP * hand)),
        "left_fingertip": Spot("left_hand", (x, y, wrist - hand)),
    }


def _of_leg(m: Measures, derived: Mapping[str, float], joints: Mapping[str, Vector3]) -> dict[str, Spot]:
    x, y, knee = joints["left_shank"]
    foot = m["foot_length"]
    heel = x - ANKLE_FROM_HEEL * foot
    return {
        "left_knee": Spot("left_thigh", (x, y, knee - derived["knee_front"])),
        "left_suprapatella": Spot("left_thigh", (x + derived["knee_above"], y, knee)),
        "left_popliteal": Spot("left_thigh", (x - derived["knee_below"], y, knee + derived["knee_back"])),
        "left_lateral_epicondyle": Spot("left_thigh", (x, y + 0.05, knee)),
        "left_tibiale": Spot("left_shank", (x, y - 0.045, m["tibial_height"])),
        "left_lateral_malleolus": Spot("left_shank", (x, y + 0.035, m["lateral_malleolus_height"])),
        "left_heel": Spot("left_foot", (heel, y, 0.0)),
        "left_ball": Spot("left_foot", (heel + BALL_FROM_HEEL * foot, y, 0.0)),
        "left_toe": Spot("left_foot", (heel + foot, y, 0.0)),
        "left_sole": Spot("left_foot", (x, y, 0.0)),
    }
