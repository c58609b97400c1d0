"""People: human figures defined by body measures."""

import math
from collections.abc import Mapping
from functools import cached_property, partial
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import Field, PrivateAttr, model_validator

from mjsim.errors import did_you_mean
from mjsim.sentences import Sentence
from mjsim.world.ground import Color, Degrees, Model, Name, Point, fault, reserved_fault
from mjsim.world.items.targets import Feet, Hands, TargetRef

if TYPE_CHECKING:  # Imported where it is used: worlds without people load faster.
    from mjsim.geometry import Array, Pose
    from mjsim.people import Figure, Mesh
    from mjsim.world.items.things import Obstacle

Percentile = Annotated[float, Field(ge=1, le=99)]
"""Percentile in the survey."""

WORN = {
    **dict.fromkeys(("thorax", "abdomen", "upper_arm"), "top"),
    **dict.fromkeys(("pelvis", "thigh", "shank"), "trousers"),
    "foot": "shoes",
}
"""Clothes by segment; the other segments show the skin."""

SITTING = {f"{side}_{joint}_flexion": math.pi / 2 for side in ("left", "right") for joint in ("hip", "knee")}
"""Joints of a seated person in plans [rad]."""


def _name_joints(schema: dict[str, Any]) -> None:
    """Add the names that keys of `joints_deg` may have to its schema, for completion."""
    from mjsim.people import Figure, Measures

    schema["propertyNames"] = {"enum": list(Figure.of(Measures.at_percentile("male")).joints)}


def _name_measures(schema: dict[str, Any]) -> None:
    """Add the names that keys of `measures` may have to its schema."""
    from mjsim.people import OUTSIDE, survey

    schema["propertyNames"] = {"enum": [name for name in survey("male").names if name not in OUTSIDE]}


class PersonColors(Model):
    """Colours of a person and of the clothes, which have no thickness."""

    skin: Color = "#c99a7c"
    """'#rrggbb'."""
    hair: Color = "#3b2a20"
    """'#rrggbb'."""
    top: Color = "#4a6d8c"
    """Trunk and upper arms, '#rrggbb'."""
    trousers: Color = "#39404a"
    """Hips and legs, '#rrggbb'."""
    shoes: Color = "#6b6259"
    """Feet, '#rrggbb'; shoes do not add to stature."""


class Person(Model):
    """A standing or seated person with body measures from ANSUR II (US Army, 2012)."""

    name: Name
    """Name; in the scene, segments are `NAME/SEGMENT` and eyes are the cameras `NAME/left_eye` and `NAME/right_eye`."""
    at: Point = (0.0, 0.0)
    """Position below the hips (when upright, between the ankles), [x, y] [m]; ignored for seated people."""
    elevation: Annotated[float, Field(ge=0, le=1e3)] | None = None
    """Height of the ground below the feet [m]; default: that of the ramp, steps or fixed level object (up to 0.5 m)
    there."""
    heading_deg: Degrees = 0.0
    """Direction that the person faces, counter-clockwise from x; seated people face along the seat."""
    seat: Name | None = None
    """The object with the seat of the person."""
    hands: Hands = Hands()
    """Targets of the hands of a seated person."""
    feet: Feet = Feet()
    """Targets of the feet of a seated person."""
    gaze: TargetRef | None = None
    """Target of the gaze of a seated person, `OBJECT.TARGET`."""
    sex: Literal["female", "male"]
    """Sex, which selects the survey."""
    percentile: Percentile = 50.0
    """Percentile of stature, among women or men of the survey."""
    measures: Annotated[Mapping[str, float], Field(max_length=36, json_schema_extra=_name_measures)] = {}
    """Individual measures instead of a percentile [m; weight in kg]; the others follow from them. For names see
    docs/people.md."""
    proportion: Percentile = 50.0
    """Percentile of sitting height among people of the same stature; higher means longer trunk and shorter legs."""
    corpulence: Percentile = 50.0
    """Percentile of weight among people of the same stature and sitting height."""
    joints_deg: Annotated[Mapping[str, float], Field(max_length=100, json_schema_extra=_name_joints)] = {}
    """Joint angles that differ from the relaxed standing pose; for names and ranges see docs/people.md."""
    colors: PersonColors = PersonColors()
    """Colours of skin, hair and clothes."""
    group: Name | None = None
    """Group that the studio selects, moves and rotates together; no effect on runs."""
    _thing: "Obstacle | None" = PrivateAttr(default=None)
    _floors: "tuple[Obstacle, ...]" = PrivateAttr(default=())

    @model_validator(mode="after")
    def _sits_or_stands(self) -> Self:
        given = self.model_fields_set
        if self.seat is None:
            if "at" not in given:
                raise fault("a person stands at a place or sits on a seat; add at: [x, y] or seat: THING")
            for key in ("hands", "feet", "gaze"):
                if getattr(self, key) != type(self).model_fields[key].default:
                    raise fault(
                        Sentence("'{key}' is for seated people; add seat: THING, or leave out '{key}'", key), key
                    )
        for key in ("at", "elevation", "heading_deg", "joints_deg") if self.seat is not None else ():
            if getattr(self, key) != type(self).model_fields[key].default:
                raise fault(
                    Sentence("the seat and its targets define the posture of a seated person; leave out '{key}'", key),
                    key,
                )
        return self

    @model_validator(mode="after")
    def _is_somebody(self) -> Self:
        if message := reserved_fault(self.name):
            raise fault(message, "name")
        if self.measures and "percentile" in self.model_fields_set:
            raise fault("a person is given by percentile or by measures; leave out one of them", "percentile")
        from mjsim.people import MeasureError

        try:
            figure = self.figure
        except MeasureError as error:
            raise fault(str(error), *self._path(error.measure)) from None
        for name, degrees in self.joints_deg.items():
            _check_joint(figure, name, degrees)
        return self

    def _path(self, measure: str) -> tuple[str, ...]:
        """Return the key to blame for an impossible measure."""
        if measure in self.measures:
            return ("measures", measure)
        return ("measures",) if self.measures else (measure,) if measure in type(self).model_fields else ("percentile",)

    @cached_property
    def figure(self) -> "Figure":
        """The body; MeasureError if no body has these measures."""
        from mjsim.people import Figure, Measures

        if self.measures:
            found = Measures.of_own(self.sex, self.measures, proportion=self.proportion, corpulence=self.corpulence)
        else:
            found = Measures.at_percentile(
                self.sex, self.percentile, proportion=self.proportion, corpulence=self.corpulence
            )
        return Figure.of(found)

    def sit_on(self, thing: "Obstacle") -> None:
        """Set the thing that `seat` names."""
        self._thing = thing

    @property
    def floors(self) -> "tuple[Obstacle, ...]":
        """Things in its world that people can stand on."""
        return self._floors

    def stand_among(self, floors: "tuple[Obstacle, ...]") -> None:
        """Set the things that people can stand on; see `floors`."""
        self._floors = floors

    def color_of(self, segment: str) -> str:
        """Return the colour of a segment, '#rrggbb'."""
        return str(getattr(self.colors, WORN.get(segment.removeprefix("left_").removeprefix("right_"), "skin")))

    def is_dressed(self, segment: str) -> bool:
        """Return whether a segment shows clothes, not skin."""
        return segment.removeprefix("left_").removeprefix("right_") in WORN

    def posture(self) -> "Array":
        """Return the joint values of the figure, in order, shape (n,) [rad]."""
        figure = self.figure
        values, names = figure.at_ease, list(figure.joints)
        for name, degrees in self.joints_deg.items():
            values[names.index(name)] = math.radians(degrees)
        return values

    def poses(self) -> "dict[str, Array]":
        """Return world_from_segment by the segment's name, shape (4, 4) each [m]; soles touch the ground.

        For ramps and steps see `mjsim.people.stand`. A sitting person has level thighs and upright shanks here;
        `mjsim.posture` finds the posture that fits seat and targets.
        """
        from mjsim.mechanics import placed

        if self._thing is not None and (seat := self._thing.seat) is not None:
            hip = placed(seat.at, (0.0, 0.0, 0.0))
            return self.figure.poses(self.figure.values(SITTING), self._thing.world_from_thing() @ hip)
        root = placed((*self.at, self.figure.segments["pelvis"].at[2]), (0.0, 0.0, math.radians(self.heading_deg)))
        values = self.posture()
        if self.elevation is None and self._floors:
            from mjsim.people import stand
            from mjsim.world.items.underfoot import height_under

            values, root = stand(self.figure, values, root, partial(height_under, self._floors), held=self.joints_deg)
        else:
            root[2, 3] += (self.elevation or 0.0) - self.figure.lowest(values)
        return self.figure.poses(values, root)

    def place(self) -> "Pose":
        """Return the position of the hips and the heading, from above, world frame."""
        from mjsim.geometry import Pose

        pelvis = self.poses()["pelvis"]
        return Pose(float(pelvis[0, 3]), float(pelvis[1, 3]), math.atan2(pelvis[1, 0], pelvis[0, 0]))

    @cached_property
    def skins(self) -> "dict[str, tuple[Mesh, ...]]":
        """Surfaces of the segments by name, each in the frame of its segment."""
        from mjsim.people import surfaces

        return surfaces(self.figure)

    @cached_property
    def prisms(self) -> "dict[str, tuple[Array, float, float]]":
        """Upright prisms that enclose the segments, by name, the lowest first.

        For each its convex outline, world frame, counter-clockwise, shape (n, 2) [m], and the heights of its lower and
        upper faces above the floor [m].
        """
        from mjsim.people import columns

        return columns(self.skins, self.poses())

    def spanned(self) -> "Array":
        """Return the corners of the prisms that enclose the body, world frame, shape (n, 3) [m]."""
        import numpy as np

        return np.concatenate([np.insert(outline, 2, high, axis=1) for outline, _, high in self.prisms.values()])


def _check_joint(figure: "Figure", name: str, degrees: float) -> None:
    """Raise if a figure has no such joint, or the angle is out of range."""
    joint = figure.joints.get(name)
    if joint is None:
        # The path ends at the key itself.
        raise fault(Sentence("no joint '{name}'{meant}", name, did_you_mean(name, figure.joints)), "joints_deg", name)
    low, high = (round(math.degrees(each), 6) for each in (joint.low, joint.high))
    if not low <= degrees <= high:
        raise fault(
            Sentence("{name} is {degrees:g} degrees; its range is {low:g} to {high:g}", name, degrees, low, high),
            "joints_deg",
            name,
        )
