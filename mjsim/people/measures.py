"""Measures of one body: from percentiles of stature, proportion and corpulence, or a person's own measures.

Percentiles of the parts of a body do not add up: a woman at the 5th percentile of stature does not have arms, legs and
trunk at the 5th percentile each. Therefore one measure is given by its percentile, and all others are the means of
people with that value.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Self

from mjsim.errors import did_you_mean
from mjsim.people.survey import PERCENTILES, SEXES, Sex, Survey, is_percentile, normal_score, survey
from mjsim.sentences import Sentence

OUTSIDE: Mapping[str, str] = {
    "functional_leg_length": "the trunk gives way when the leg is stretched, and a rigid one does not",
    "span": "the shoulder blades move inwards when arms are raised sideways, and a figure has no joint there",
}
"""Measures that a figure does not reproduce, each with the reason."""
MAX_SIGMAS = 5.0
"""Maximum deviation of a measure from its expectation given the others, in standard deviations."""


class MeasureError(ValueError):
    """An impossible measure, alone or in combination with others."""

    def __init__(self, measure: str, message: str) -> None:
        self.measure = measure
        """Name of the measure or of a percentile."""
        super().__init__(message)


@dataclass(frozen=True, slots=True, eq=False)
class Measures(Mapping[str, float]):
    """36 measures of one body, by their names in `Survey` [m; weight in kg]."""

    sex: Sex
    values_by_name: Mapping[str, float]
    """All measures [m; weight in kg]."""
    own: tuple[str, ...] = ()
    """Names of those that were given; the others are derived from them."""

    def __getitem__(self, name: str) -> float:
        """Return a measure [m; weight in kg]."""
        return self.values_by_name[name]

    def __iter__(self) -> Iterator[str]:
        """Yield the names of the measures."""
        return iter(self.values_by_name)

    def __len__(self) -> int:
        """Return the number of measures."""
        return len(self.values_by_name)

    @classmethod
    def at_percentile(
        cls, sex: Sex, percentile: float = 50.0, *, proportion: float = 50.0, corpulence: float = 50.0
    ) -> Self:
        """Return the measures of a body by the percentile of its stature.

        Args:
            sex: 'female' or 'male'.
            percentile: Percentile of stature in the survey's table, 1 to 99.
            proportion: Percentile of sitting height among people of this stature, 1 to 99; higher means a longer trunk.
            corpulence: Percentile of weight among people of this stature and sitting height, 1 to 99.

        Raises:
            MeasureError: The sex does not exist, or a percentile is outside the table.
        """
        table = _table(sex)
        _check_percentile("percentile", percentile)
        return cls._completed(table, {"stature": table.at_percentile("stature", percentile)}, proportion, corpulence)

    @classmethod
    def of_own(cls, sex: Sex, own: Mapping[str, float], *, proportion: float = 50.0, corpulence: float = 50.0) -> Self:
        """Return a person's own measures, and the expected values of the others given these.

        Args:
            sex: 'female' or 'male'.
            own: The person's measures by name [m; weight in kg].
            proportion: As for `at_percentile`, if sitting height is not given.
            corpulence: As for `at_percentile`, if weight is not given.

        Raises:
            MeasureError: There is no such sex or measure, a percentile is outside the table, or no body has this
                combination of measures.
        """
        table = _table(sex)
        check_own(table, own)
        for key, percentile, measure in (
            ("proportion", proportion, "sitting_height"),
            ("corpulence", corpulence, "weight"),
        ):
            if measure in own and percentile != 50.0:
                raise MeasureError(
                    key,
                    Sentence(
                        "{key} is {percentile:g}, but {measure} is given; leave out one of them",
                        key,
                        percentile,
                        measure,
                    ),
                )
        return cls._completed(table, own, proportion, corpulence)

    @classmethod
    def _completed(cls, table: Survey, own: Mapping[str, float], proportion: float, corpulence: float) -> Self:
        _check_percentile("proportion", proportion)
        _check_percentile("corpulence", corpulence)
        known = dict(own)
        for name, percentile in (("sitting_height", proportion), ("weight", corpulence)):
            if name not in known:
                mean, sd = table.given(known)
                place = table.index(name)
                known[name] = float(mean[place] + normal_score(percentile) * sd[place])
        mean, _ = table.given(known)
        values = dict(zip(table.names, mean.tolist(), strict=True))
        return cls(table.sex, MappingProxyType(values), tuple(own))


def check_own(table: Survey, own: Mapping[str, float]) -> None:
    """Raise MeasureError if a measure does not exist, or is impossible alone or together with the other given ones."""
    for name, value in own.items():
        if name not in table.names:
            raise MeasureError(
                name, Sentence("no measure '{name}'{did_you_mean}", name, did_you_mean(name, table.names))
            )
        place = table.index(name)
        if name in OUTSIDE:
            raise MeasureError(
                name,
                Sentence(
                    "the model of a person does not reproduce {name}: {outside}; leave it out", name, OUTSIDE[name]
                ),
            )
        _check_deviation(name, value, table.mean[place], table.sd[place], f"of {_PEOPLE[table.sex]}")
    for name, value in own.items():
        mean, sd = table.given({other: each for other, each in own.items() if other != name})
        place = table.index(name)
        _check_deviation(name, value, mean[place], sd[place], "beside the other measures")


_PEOPLE: Mapping[Sex, str] = {"female": "women", "male": "men"}


def _check_deviation(name: str, value: float, mean: float, sd: float, whose: str) -> None:
    low, high = mean - MAX_SIGMAS * sd, mean + MAX_SIGMAS * sd
    if not low <= value <= high:
        unit = "kg" if name == "weight" else "m"
        raise MeasureError(
            name,
            Sentence(
                "{name} is {value:g} {unit}; {whose} it lies between {low:.3g} and {high:.3g} {unit}",
                name,
                value,
                unit,
                whose,
                low,
                high,
            ),
        )


def _table(sex: Sex) -> Survey:
    if sex not in SEXES:
        raise MeasureError("sex", Sentence("sex is '{sex}'; it must be 'female' or 'male'", sex))
    return survey(sex)


def _check_percentile(key: str, value: float) -> None:
    if not is_percentile(value):
        raise MeasureError(
            key,
            Sentence(
                "{key} is {value:g}; it must be from {percentiles:g} to {other_percentiles:g}",
                key,
                value,
                PERCENTILES[0],
                PERCENTILES[-1],
            ),
        )
