"""What all models of the world file share: strict, frozen, and documented for the schema."""

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

PHYSICS_STEP = 0.004
"""Period of the physics [s]; every tick is a whole number of these."""


class Model(BaseModel):
    """A part of a world file: values are checked once, unknown keys are refused."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", strict=True, allow_inf_nan=False, use_attribute_docstrings=True
    )


Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9_][A-Za-z0-9_.-]*$", max_length=64)]
"""A name: letters, digits, `_`, `.` and `-`."""

Metres = Annotated[float, Field(ge=-1e4, le=1e4)]
Length = Annotated[float, Field(gt=0, le=1e4)]
"""A length above zero [m]."""
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
Color = Annotated[str, Field(pattern=r"^#[0-9a-fA-F]{6}$")]
"""'#rrggbb'."""
AssetPath = Annotated[str, Field(min_length=1, max_length=512)]
"""A file, looked for beside the world file, then among the assets that come with mjsim."""
