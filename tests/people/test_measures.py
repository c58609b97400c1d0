"""Measures of bodies: by percentile, by proportion and corpulence, and a person's own."""

import json
import math
from importlib import resources
from statistics import NormalDist

import numpy as np
import pytest

from mjsim.people import OUTSIDE, SEXES, Figure, Measures, measured
from mjsim.people.survey import SURVEY_NAMES

TABLE = json.loads(resources.files("mjsim.assets").joinpath("people/ansur2.json").read_text())
UNITS = {"weight": 0.1, "interpupillary_breadth": 1e-4}


def conditional_means(sex, known):
    """Return means of all measures given some, by precision matrices: another way than the code's."""
    names = TABLE["correlation"][sex]["names"]
    sd = np.array([TABLE["measures"][name][sex]["sd"] for name in names])
    mean = np.array([TABLE["measures"][name][sex]["mean"] for name in names])
    precision = np.linalg.inv(np.array(TABLE["correlation"][sex]["matrix"]) * np.outer(sd, sd))
    places = [names.index(name) for name in known]
    others = [place for place in range(len(names)) if place not in places]
    found = mean.copy()
    found[places] = list(known.values())
    gain = np.linalg.solve(precision[np.ix_(others, others)], precision[np.ix_(others, places)])
    found[others] -= gain @ (found[places] - mean[places])
    return dict(zip(names, found, strict=True))


@pytest.mark.parametrize("sex", SEXES)
@pytest.mark.parametrize("percentile", [5, 50, 95])
def test_stature_is_the_tables_percentile_and_the_rest_are_means_of_those_who_have_it(sex, percentile):
    stature = TABLE["measures"]["stature"][sex][f"p{percentile}"]
    taken = measured(Figure.of(Measures.at_percentile(sex, percentile)))
    assert taken["stature"] == pytest.approx(stature * 1e-3, abs=1e-3)
    wanted = conditional_means(sex, {"stature": stature})
    for name in set(taken) - set(OUTSIDE):
        unit = UNITS.get(name, 1e-3)
        assert taken[name] == pytest.approx(wanted[SURVEY_NAMES[name]] * unit, abs=1e-6), name


def test_own_measures_are_kept_and_the_rest_are_means_given_them():
    own = {"stature": 1.83, "sitting_height": 0.93, "weight": 95.0, "knee_height_sitting": 0.58}
    taken = measured(Figure.of(Measures.of_own("male", own)))
    known = {SURVEY_NAMES[name]: value / UNITS.get(name, 1e-3) for name, value in own.items()}
    wanted = conditional_means("male", known)
    for name in set(taken) - set(OUTSIDE):
        assert taken[name] == pytest.approx(wanted[SURVEY_NAMES[name]] * UNITS.get(name, 1e-3), abs=1e-6), name


@pytest.mark.slow
def test_each_measure_alone_is_kept_at_percentiles_5_and_95():
    for sex in SEXES:
        for name in set(SURVEY_NAMES) - set(OUTSIDE):
            for key in ("p5", "p95"):
                value = TABLE["measures"][SURVEY_NAMES[name]][sex][key] * UNITS.get(name, 1e-3)
                taken = measured(Figure.of(Measures.of_own(sex, {name: value})))
                assert taken[name] == pytest.approx(value, abs=1e-3), (sex, name, key)


def test_proportion_and_corpulence_are_percentiles_among_people_of_the_same_stature():
    middle = Measures.at_percentile("female", 50)
    long, heavy = (Measures.at_percentile("female", 50, **{key: 90.0}) for key in ("proportion", "corpulence"))
    table = TABLE["measures"]["sittingheight"]["female"]
    names = TABLE["correlation"]["female"]["names"]
    r = TABLE["correlation"]["female"]["matrix"][names.index("stature")][names.index("sittingheight")]
    step = NormalDist().inv_cdf(0.9) * table["sd"] * math.sqrt(1.0 - r**2) * 1e-3
    assert long["sitting_height"] - middle["sitting_height"] == pytest.approx(step)
    assert long["stature"] == heavy["stature"] == middle["stature"]
    assert heavy["sitting_height"] == pytest.approx(middle["sitting_height"])
    assert heavy["waist_depth"] > middle["waist_depth"] + 0.03
    assert long["trochanterion_height"] < middle["trochanterion_height"]


@pytest.mark.parametrize(
    ("own", "said"),
    [
        ({"stature": 3.0}, "stature is 3 m; of men it lies between 1.41 and 2.1 m"),
        ({"stature": math.nan}, "stature is nan m; of men it lies between 1.41 and 2.1 m"),
        ({"statur": 1.8}, "no measure 'statur'; did you mean 'stature'?"),
        ({"stature": 1.6, "cervicale_height": 1.5}, "stature is 1.6 m; beside the other measures it lies between"),
        (
            {"span": 1.8},
            "the model of a person does not reproduce span: the shoulder blades move inwards when arms are raised",
        ),
    ],
)
def test_impossible_body_measures_are_refused(own, said):
    with pytest.raises(ValueError, match="^" + said.replace("?", r"\?")):
        Measures.of_own("male", own)


@pytest.mark.parametrize("key", ["percentile", "proportion", "corpulence"])
@pytest.mark.parametrize("value", [0.0, 100.0, math.nan, -5.0])
def test_percentiles_outside_of_the_table_are_refused(key, value):
    with pytest.raises(ValueError, match=f"{key} is .*; it must be from 1 to 99"):
        Measures.at_percentile("female", **{"percentile": 50.0, key: value})
