"""Body measures of a population: means, percentiles and correlations, from ANSUR II.

References:
    Gordon et al., 2012 Anthropometric Survey of U.S. Army Personnel, NATICK/TR-15/007 (2014); assets/people/README.md.
"""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources
from statistics import NormalDist
from typing import Literal, get_args

import numpy as np

from mjsim.errors import did_you_mean
from mjsim.geometry import Array
from mjsim.sentences import Sentence

Sex = Literal["female", "male"]
SEXES: tuple[Sex, ...] = get_args(Sex)
PERCENTILES = (1.0, 5.0, 50.0, 95.0, 99.0)
"""Percentiles in the survey's table."""
FILE = "people/ansur2.json"

_MILLI, _TENTH = 1e-3, 0.1
SURVEY_NAMES = {
    "stature": "stature",
    "sitting_height": "sittingheight",
    "eye_height_sitting": "eyeheightsitting",
    "acromial_height": "acromialheight",
    "upper_arm_length": "acromionradialelength",
    "forearm_length": "radialestylionlength",
    "hand_length": "handlength",
    "palm_length": "palmlength",
    "buttock_knee_length": "buttockkneelength",
    "buttock_popliteal_length": "buttockpopliteallength",
    "knee_height_sitting": "kneeheightsitting",
    "popliteal_height": "poplitealheight",
    "trochanterion_height": "trochanterionheight",
    "lateral_epicondyle_height": "lateralfemoralepicondyleheight",
    "lateral_malleolus_height": "lateralmalleolusheight",
    "foot_length": "footlength",
    "biacromial_breadth": "biacromialbreadth",
    "bideltoid_breadth": "bideltoidbreadth",
    "bicristal_breadth": "bicristalbreadth",
    "hip_breadth_sitting": "hipbreadthsitting",
    "thumb_tip_reach": "thumbtipreach",
    "functional_leg_length": "functionalleglength",
    "forearm_hand_length": "forearmhandlength",
    "tibial_height": "tibialheight",
    "cervicale_height": "cervicaleheight",
    "suprasternale_height": "suprasternaleheight",
    "iliocristale_height": "iliocristaleheight",
    "head_length": "headlength",
    "head_breadth": "headbreadth",
    "tragion_to_vertex": "tragiontopofhead",
    "waist_depth": "waistdepth",
    "chest_depth": "chestdepth",
    "weight": "weightkg",
    "interpupillary_breadth": "interpupillarybreadth",
    "span": "span",
    "elbow_rest_height": "elbowrestheight",
}
"""Names of measures here -> names in the survey's files."""
_SCALES = {"weight": _TENTH, "interpupillary_breadth": _TENTH * _MILLI}
"""Scales of measures that are not in mm in the survey's files."""


@dataclass(frozen=True, slots=True, eq=False)
class Survey:
    """Measures of the men or the women of a survey, assumed to be jointly normal."""

    sex: Sex
    names: tuple[str, ...]
    """Names of the measures, n of them."""
    mean: Array
    """Shape (n,) [m; weight in kg]."""
    sd: Array
    """Standard deviations, shape (n,) [m; weight in kg]."""
    percentiles: Array
    """Values at `PERCENTILES`, shape (n, 5)."""
    correlation: Array
    """Shape (n, n)."""

    def index(self, name: str) -> int:
        """Return the index of a measure; raises ValueError if there is none of this name."""
        if name not in self.names:
            raise ValueError(Sentence("no measure '{name}'{did_you_mean}", name, did_you_mean(name, self.names)))
        return self.names.index(name)

    def at_percentile(self, name: str, percentile: float) -> float:
        """Return the value of a measure at a percentile, interpolated in the table by normal scores [m or kg]."""
        scores = [normal_score(each) for each in PERCENTILES]
        return float(np.interp(normal_score(percentile), scores, self.percentiles[self.index(name)]))

    def given(self, known: Mapping[str, float]) -> tuple[Array, Array]:
        """Return mean and standard deviation of all measures, given some.

        Args:
            known: Values by name [m; weight in kg].

        Returns:
            mean: Shape (n,); known measures keep their values.
            sd: Shape (n,); 0 for known measures.

        References:
            Conditionals of the multivariate normal distribution: Bishop, Pattern Recognition and Machine Learning
            (2006), equations 2.81 and 2.82.
        """
        if not known:
            return self.mean.copy(), self.sd.copy()
        places = [self.index(name) for name in known]
        covariance = self.correlation * np.outer(self.sd, self.sd)
        values = np.array(list(known.values()), dtype=float)
        gain = np.linalg.solve(covariance[np.ix_(places, places)], covariance[places]).T
        mean = self.mean + gain @ (values - self.mean[places])
        variance = np.diag(covariance) - np.einsum("ij,ji->i", gain, covariance[places])
        variance[places], mean[places] = 0.0, values
        return mean, np.sqrt(np.maximum(variance, 0.0))


def normal_score(percentile: float) -> float:
    """Return the z-score of a percentile of a normal distribution: its distance above the mean over the deviation."""
    return NormalDist().inv_cdf(percentile / 100.0)


@cache
def survey(sex: Sex) -> Survey:
    """Return the survey's table of men or women."""
    table = json.loads(resources.files("mjsim.assets").joinpath(FILE).read_text(encoding="utf-8"))
    names = tuple(SURVEY_NAMES)
    scales = np.array([_SCALES.get(name, _MILLI) for name in names])
    rows = [table["measures"][SURVEY_NAMES[name]][sex] for name in names]
    correlation = table["correlation"][sex]
    order = [correlation["names"].index(SURVEY_NAMES[name]) for name in names]
    return Survey(
        sex=sex,
        names=names,
        mean=np.array([row["mean"] for row in rows]) * scales,
        sd=np.array([row["sd"] for row in rows]) * scales,
        percentiles=np.array([[row[f"p{each:g}"] for each in PERCENTILES] for row in rows]) * scales[:, None],
        correlation=np.array(correlation["matrix"])[np.ix_(order, order)],
    )


def is_percentile(value: float) -> bool:
    """Return whether a percentile is in the range of the table."""
    return math.isfinite(value) and PERCENTILES[0] <= value <= PERCENTILES[-1]
