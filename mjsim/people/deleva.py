"""Masses, centres and radii of gyration of body segments.

References:
    de Leva, Adjustments to Zatsiorsky-Seluyanov's segment inertia parameters, Journal of Biomechanics 29(9), 1223-1230
    (1996), table 4. Endpoints: head from vertex to cervicale, thorax from suprasternale to xiphion, abdomen from
    xiphion to omphalion, pelvis from omphalion to the middle of the hip joints, hand from wrist to the tip of the third
    finger, shank from knee to lateral malleolus, foot from heel to toe, others from joint to joint. Levels of xiphion
    and omphalion from table 2: the lengths of the trunk's parts.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from mjsim.people.survey import Sex


@dataclass(frozen=True, slots=True)
class Share:
    """Parameters of a segment relative to the body and to its own length."""

    mass: float
    """As a fraction of the body's mass."""
    center: float
    """Distance of its centre of mass from its upper endpoint (for the foot, from the heel), as a fraction of its
    length."""
    sagittal: float
    """Radius of gyration about the forward axis, as a fraction of its length."""
    transverse: float
    """Radius of gyration about the axis to the left, as a fraction of its length."""
    longitudinal: float
    """Radius of gyration about the axis between the endpoints, as a fraction of its length."""


SHARES: Mapping[Sex, Mapping[str, Share]] = {
    "female": {
        "head": Share(0.0668, 0.4841, 0.271, 0.295, 0.261),
        "thorax": Share(0.1545, 0.2077, 0.746, 0.502, 0.718),
        "abdomen": Share(0.1465, 0.4512, 0.433, 0.354, 0.415),
        "pelvis": Share(0.1247, 0.4920, 0.433, 0.402, 0.444),
        "upper_arm": Share(0.0255, 0.5754, 0.278, 0.260, 0.148),
        "forearm": Share(0.0138, 0.4559, 0.261, 0.257, 0.094),
        "hand": Share(0.0056, 0.3427, 0.244, 0.208, 0.154),
        "thigh": Share(0.1478, 0.3612, 0.369, 0.364, 0.162),
        "shank": Share(0.0481, 0.4416, 0.271, 0.267, 0.093),
        "foot": Share(0.0129, 0.4014, 0.299, 0.279, 0.139),
    },
    "male": {
        "head": Share(0.0694, 0.5002, 0.303, 0.315, 0.261),
        "thorax": Share(0.1596, 0.2999, 0.716, 0.454, 0.659),
        "abdomen": Share(0.1633, 0.4502, 0.482, 0.383, 0.468),
        "pelvis": Share(0.1117, 0.6115, 0.615, 0.551, 0.587),
        "upper_arm": Share(0.0271, 0.5772, 0.285, 0.269, 0.158),
        "forearm": Share(0.0162, 0.4574, 0.276, 0.265, 0.121),
        "hand": Share(0.0061, 0.3624, 0.288, 0.235, 0.184),
        "thigh": Share(0.1416, 0.4095, 0.329, 0.329, 0.149),
        "shank": Share(0.0433, 0.4459, 0.255, 0.249, 0.103),
        "foot": Share(0.0137, 0.4415, 0.257, 0.245, 0.124),
    },
}
PAIRED = ("upper_arm", "forearm", "hand", "thigh", "shank", "foot")
"""Segments that exist on both sides."""

TRUNK_LEVELS: Mapping[Sex, tuple[float, float]] = {
    "female": (181.5 / 614.8, (181.5 + 205.3) / 614.8),
    "male": (145.7 / 603.3, (145.7 + 215.5) / 603.3),
}
"""Heights of omphalion and xiphion above the hip joints, as fractions of that of the cervicale."""


def share_of(sex: Sex, segment: str) -> Share:
    """Return the parameters of a segment, with masses scaled to add up to 1: those in the table are rounded."""
    table = SHARES[sex]
    whole = sum(each.mass * (2 if name in PAIRED else 1) for name, each in table.items())
    share = table[segment]
    return Share(share.mass / whole, share.center, share.sagittal, share.transverse, share.longitudinal)
