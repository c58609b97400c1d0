"""Print how well figures keep the measures of the survey, the masses of the tables, and the reach of people.

python scripts/measure/people.py [--people N]

Expected values are computed here from the survey's table and from de Leva's, not by the package. What is drawn comes
with its standard error: of 100 people a scatter of 26 mm is found as 22 to 30 mm.
"""

import argparse
import json
from collections.abc import Iterable, Mapping
from importlib import resources

import numpy as np

from mjsim.geometry import Array
from mjsim.people import OUTSIDE, SEXES, Figure, MeasureError, Measures, Sex, measured
from mjsim.people.deleva import PAIRED, SHARES
from mjsim.people.survey import SURVEY_NAMES

TABLE = json.loads(resources.files("mjsim.assets").joinpath("people/ansur2.json").read_text(encoding="utf-8"))
UNITS = {"weight": 0.1, "interpupillary_breadth": 1e-4}
"""Of what is not in mm in the table."""
KEPT = [name for name in SURVEY_NAMES if name not in OUTSIDE]
ARM = ("stature", "acromial_height", "upper_arm_length", "forearm_length", "hand_length", "chest_depth")


class Population:
    """Women or men of the survey, in metres and kilograms."""

    def __init__(self, sex: Sex) -> None:
        self.sex = sex
        rows = [TABLE["measures"][name][sex] for name in SURVEY_NAMES.values()]
        units = np.array([UNITS.get(name, 1e-3) for name in SURVEY_NAMES])
        names = TABLE["correlation"][sex]["names"]
        order = [names.index(name) for name in SURVEY_NAMES.values()]
        sd = np.array([row["sd"] for row in rows]) * units
        self.rows = dict(zip(SURVEY_NAMES, rows, strict=True))
        self.mean = np.array([row["mean"] for row in rows]) * units
        self.covariance = np.array(TABLE["correlation"][sex]["matrix"])[np.ix_(order, order)] * np.outer(sd, sd)

    def value(self, name: str, percentile: int) -> float:
        """Return a value of the table."""
        return float(self.rows[name][f"p{percentile}"] * UNITS.get(name, 1e-3))

    def given(self, known: Mapping[str, float]) -> dict[str, float]:
        """Return conditional means, by the inverse of the covariance."""
        inverse, names = np.linalg.inv(self.covariance), list(SURVEY_NAMES)
        here = [names.index(name) for name in known]
        rest = [place for place in range(len(names)) if place not in here]
        found = self.mean.copy()
        found[here] = list(known.values())
        step = inverse[np.ix_(rest, here)] @ (found[here] - self.mean[here])
        found[rest] -= np.linalg.solve(inverse[np.ix_(rest, rest)], step)
        return dict(zip(names, found.tolist(), strict=True))

    def scatter(self, name: str, known: Iterable[str]) -> float:
        """Return the standard deviation of a measure among people who have the same known ones, by its regression."""
        names = list(SURVEY_NAMES)
        here, place = [names.index(each) for each in known], names.index(name)
        among = self.covariance[np.ix_(here, here)]
        shared = self.covariance[here, place]
        return float(np.sqrt(self.covariance[place, place] - shared @ np.linalg.solve(among, shared)))


def percentiles(people: Population) -> None:
    """Compare figures by percentile with the table and with conditional means."""
    stature, others = 0.0, dict.fromkeys(SURVEY_NAMES, 0.0)
    for percentile in (5, 50, 95):
        wanted = people.given({"stature": people.value("stature", percentile)})
        taken = measured(Figure.of(Measures.at_percentile(people.sex, percentile)))
        stature = max(stature, abs(taken["stature"] - people.value("stature", percentile)))
        others = {name: max(worst, taken[name] - wanted[name], key=abs) for name, worst in others.items()}
    kept = max(abs(others[name]) for name in KEPT)
    print(f"{people.sex}: stature at p5, p50, p95 against the table: within {1000 * stature:.3f} mm")
    print(f"{people.sex}: {len(KEPT) - 1} other measures against conditional means: within {1000 * kept:.3f} mm (kg)")
    for name in OUTSIDE:
        print(f"{people.sex}: {name}: {1000 * others[name]:+.0f} mm ({OUTSIDE[name]})")


def own_measures(people: Population, count: int, rng: np.random.Generator) -> None:
    """Give figures some measures of people who might be, and look whether they have them."""
    worst, refused = 0.0, 0
    for drawn in rng.multivariate_normal(people.mean, people.covariance, count):
        person = dict(zip(SURVEY_NAMES, drawn.tolist(), strict=True))
        own = {str(name): person[str(name)] for name in rng.choice(KEPT, rng.integers(1, 7), replace=False)}
        try:
            taken = measured(Figure.of(Measures.of_own(people.sex, own)))
        except MeasureError:
            refused += 1
            continue
        worst = max(worst, *(abs(taken[name] - own[name]) for name in own))
    print(
        f"{people.sex}: 1 to 6 own measures of {count} people: kept within {1000 * worst:.3f} mm; {refused} refused,"
        " which no rigid figure can have together"
    )


def reach(people: Population, count: int, rng: np.random.Generator) -> None:
    """Compare the reach of figures that have the arms of people with the reach of these people."""
    errors = []
    for drawn in rng.multivariate_normal(people.mean, people.covariance, count):
        person = dict(zip(SURVEY_NAMES, drawn.tolist(), strict=True))
        try:
            figure = Figure.of(Measures.of_own(people.sex, {name: person[name] for name in ARM}))
        except MeasureError:
            continue
        errors.append(measured(figure)["thumb_tip_reach"] - person["thumb_tip_reach"])
    survey, found = people.scatter("thumb_tip_reach", ARM), len(errors)
    bias, scatter = 1000 * np.mean(errors), 1000 * np.std(errors, ddof=1)
    print(
        f"{people.sex}: thumb-tip reach of {found} people by {len(ARM)} measures: bias {bias:+.1f} +- "
        f"{scatter / np.sqrt(found):.1f} mm, scatter {scatter:.1f} +- {scatter / np.sqrt(2 * found):.1f} mm "
        f"(standard errors); of the survey among people with the same {len(ARM)} measures {1000 * survey:.1f} mm"
    )


def masses(sex: Sex) -> None:
    """Compare masses and centres with the table; neck and head are one there."""
    figure = Figure.of(Measures.at_percentile(sex, 50))
    weight, poses = figure.measures["weight"], figure.poses()
    whole = sum(share.mass * (1 + (name in PAIRED)) for name, share in SHARES[sex].items())
    ends: dict[str, tuple[Array, Array]] = {}
    for name, below in (("upper_arm", "forearm"), ("forearm", "hand"), ("thigh", "shank"), ("shank", "foot")):
        ends[name] = poses[f"left_{name}"][:3, 3], poses[f"left_{below}"][:3, 3]
    mass = center = 0.0
    for name, share in SHARES[sex].items():
        parts = ["neck", "head"] if name == "head" else [f"left_{name}" if name in PAIRED else name]
        found = sum(figure.segments[part].solid.mass for part in parts)
        mass = max(mass, abs(found / weight - share.mass / whole))
        if name in ends:
            upper, lower = ends[name]
            wanted = upper + share.center * (lower - upper)
            has = poses[parts[0]][:3, 3] + figure.segments[parts[0]].solid.center
            center = max(center, float(np.linalg.norm(has - wanted)))
    total = sum(segment.solid.mass for segment in figure.segments.values()) - weight
    print(
        f"{sex}: total mass off by {1000 * total:.3f} g; masses of segments within {mass:.1e} of the weight;"
        f" centres of limbs within {1000 * center:.3f} mm"
    )


def main() -> None:
    """Print all comparisons."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--people", type=int, default=500, help="how many people are drawn")
    count = parser.parse_args().people
    for sex in SEXES:
        people, rng = Population(sex), np.random.default_rng(0)
        percentiles(people)
        own_measures(people, count, rng)
        reach(people, count, rng)
        masses(sex)


if __name__ == "__main__":
    main()
