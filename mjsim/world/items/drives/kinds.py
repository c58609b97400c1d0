"""All drives by their type."""

from collections.abc import Mapping
from typing import Annotated, Any, get_args

from pydantic import BaseModel

from mjsim.sentences import Sentence
from mjsim.world.ground import OneOf
from mjsim.world.items.drives.ackermann import AckermannDrive
from mjsim.world.items.drives.balancing import BalancingDrive
from mjsim.world.items.drives.base import AnyDrive
from mjsim.world.items.drives.differential import DifferentialDrive
from mjsim.world.items.drives.fixed import FixedDrive
from mjsim.world.items.drives.mecanum import MecanumDrive
from mjsim.world.items.drives.omni3 import Omni3Drive
from mjsim.world.items.drives.skid_steer import SkidSteerDrive
from mjsim.world.items.drives.tricycle import TricycleDrive
from mjsim.world.items.drives.user import UserDrive

RollingDrive = (
    DifferentialDrive | SkidSteerDrive | AckermannDrive | TricycleDrive | Omni3Drive | MecanumDrive | BalancingDrive
)
KINDS: Mapping[str, type[AnyDrive]] = {
    get_args(model.model_fields["type"].annotation)[0]: model for model in get_args(RollingDrive)
}
"""Drives by their `type`."""


def _kind_of_drive(item: Any, kinds: Mapping[str, type[BaseModel]]) -> str | None:
    """Return the type of a drive (differential by default), or `use` for the user's own."""
    if isinstance(item, UserDrive) or (isinstance(item, dict) and "use" in item):
        return "use"
    kind = item.get("type", "differential") if isinstance(item, dict) else getattr(item, "type", None)
    return kind if isinstance(kind, str) and kind in kinds else None


Drive = Annotated[
    RollingDrive | UserDrive | FixedDrive,
    OneOf(
        {**KINDS, "use": UserDrive, "fixed": FixedDrive},
        Sentence(
            'a drive has a type: {kinds} or {last}; or a class of your own, {{use: "my_drive.py:MyDrive"}}',
            ", ".join([*KINDS][:-1]),
            [*KINDS][-1],
        ),
        _kind_of_drive,
    ),
]
