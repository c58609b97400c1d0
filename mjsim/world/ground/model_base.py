"""Base of all models of the world file: strict, frozen, and documented for the schema."""

from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, GetJsonSchemaHandler, ValidationInfo
from pydantic_core import CoreSchema, PydanticCustomError

from mjsim.sentences import Sentence
from mjsim.world.files import Source, check_picture, read_asset
from mjsim.world.ground.descriptions import descriptions
from mjsim.world.ground.names import legible

KEY = "[key]"
"""Last step of a path that refers to a key itself, not its value; defined by pydantic."""


class Model(BaseModel):
    """A part of a world file: values are validated once, unknown keys are rejected."""

    # Most models are validated only as part of a world: their own validators are built on first use.
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False, defer_build=True)

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """Return the JSON Schema of the model with a description of each field."""
        made = handler(schema)
        properties = handler.resolve_ref_schema(made).get("properties", {})
        for field, text in descriptions(cls).items():
            properties[field].setdefault("description", text)
        return made


@dataclass(frozen=True, slots=True)
class Slider:
    """Marks, in `Annotated`, a number that may change during a run, with its useful range."""

    low: float
    high: float


def fault(message: str, *path: str | int) -> PydanticCustomError:
    """Return the exception for a validator: a message, and the path of the value below the one being validated."""
    return PydanticCustomError("mjsim", "{text}", {"text": message, "path": path})


def _existing_picture(name: str, info: ValidationInfo) -> str:
    """Check that a picture exists, if the reader of a file provides the source."""
    source = (info.context or {}).get("source")
    if isinstance(source, Source):
        check_picture(name, source)
    return name


def _existing_model(name: str, info: ValidationInfo) -> str:
    """Check that an MJCF, URDF, xacro or SDF file exists, if the reader of a file provides the source."""
    if not name.lower().endswith((".xml", ".mjcf", ".urdf", ".xacro", ".sdf")):
        raise ValueError(
            Sentence("'{name}' is not a model; name an MJCF (.xml), URDF (.urdf), xacro or SDF (.sdf) file", name)
        )
    source = (info.context or {}).get("source")
    if isinstance(source, Source) and name not in source.attached:
        read_asset(name, source)
    return name


# Of ASCII only letters, digits and a few signs; of the rest `legible` admits letters and digits.
_HEAD, _PART, _TAIL = (rf"[^\x00-{last}:-@\[-^`{{-\x7f]" for last in ("/", ",./", ",/"))
NAME_PATTERN = rf"^{_HEAD}{_TAIL}*$"
COLOR_PATTERN = r"^#[0-9a-fA-F]{6}$"
PART_PATTERN = rf"^{_TAIL}+/[A-Za-z0-9]+$"
JOINT_PATTERN = rf"^{_HEAD}{_PART}*$"
POINT_PATTERN = rf"^{_PART}+(\.{_PART}+)?$"
TARGET_PATTERN = rf"^{_HEAD}{_TAIL}*\.{_HEAD}{_PART}*$"
PLAIN_PATTERN = r"^[^\x00-\x1f]+$"
COMPLEX_PATTERN = r"^[-+0-9.eE ]*[ij]$"
PLANT_PATTERN = rf"^{_HEAD}{_TAIL}*(/{_HEAD}{_TAIL}*)?$"
USE_PATTERN = r"^(exec:.+|[^:]+\.m|[^:]+:[A-Za-z_][A-Za-z0-9_]*)$"

Legible = AfterValidator(legible)
"""Completes the patterns of names: see `legible`."""
Name = Annotated[str, Field(pattern=NAME_PATTERN, max_length=64), Legible]
"""A name: letters and digits of any script, `_`, `.` and `-`."""

MIN_SIZE = 1e-5
"""Meshes of smaller things have no volume, and bodies of their size no inertia [m]."""


def _require_visible(length: float) -> float:
    if length < MIN_SIZE:
        raise ValueError(Sentence("a length is {length:g} m; it must be at least {min_size:g} m", length, MIN_SIZE))
    return length


Metres = Annotated[float, Field(ge=-1e4, le=1e4)]
Length = Annotated[float, Field(gt=0, le=1e4), AfterValidator(_require_visible)]
"""A length above zero, at least `MIN_SIZE` [m]."""
Distance = Annotated[float, Field(ge=0, le=1e4)]
"""A distance, zero allowed [m]."""
Degrees = Annotated[float, Field(ge=-3600, le=3600)]
Deviation = Annotated[float, Field(ge=0, le=1e3)]
"""A standard deviation, or a noise density."""
Rate = Annotated[float, Field(gt=0, le=1000)]
"""[Hz]"""

Point = Annotated[tuple[Metres, ...], Field(strict=False, min_length=2, max_length=2)]
"""[x, y] in the world [m]."""
Point3 = Annotated[tuple[Metres, ...], Field(strict=False, min_length=3, max_length=3)]
"""[x, y, z] [m]."""
RollPitchYaw = Annotated[tuple[Degrees, ...], Field(strict=False, min_length=3, max_length=3)]
"""[roll, pitch, yaw], right-handed, in this order."""
Color = Annotated[str, Field(pattern=COLOR_PATTERN)]
"""'#rrggbb'."""
AssetPath = Annotated[str, Field(min_length=1, max_length=200), AfterValidator(_existing_picture)]
"""A picture, looked for beside the world file, then among the assets that come with mjsim."""
ModelPath = Annotated[str, Field(min_length=1, max_length=200), AfterValidator(_existing_model)]
"""An MJCF, URDF, xacro or SDF file, looked for beside the world file, then among the assets of mjsim."""
