"""MJCF and URDF files named by items of a world."""

from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Any, Self

from pydantic import Field, PrivateAttr, ValidationInfo, model_validator

from mjsim.world.files import BUILT, Source, read_asset
from mjsim.world.ground import Model, ModelPath, fault

if TYPE_CHECKING:  # and below where it is used: worlds without models start without it
    from mjsim.models import ModelShape


class FromFile(Model):
    """An item with its shape from an MJCF (MuJoCo) or URDF (ROS) file."""

    model: ModelPath
    """The file; its meshes and pictures must be beside it or below the world file."""
    scale: Annotated[float, Field(gt=0, le=1e4)] = 1.0
    """Metres per unit of length in the file."""
    _source: Source = PrivateAttr(default=BUILT)

    @model_validator(mode="after")
    def _can_be_read(self, info: ValidationInfo) -> Self:
        context = info.context or {}
        source = context.get("source")
        if isinstance(source, Source):
            self._source = source
            # Many chairs of one file are read once.
            vars(self)["shape"] = shape_in(context, self.model, self._read)
        return self

    @cached_property
    def shape(self) -> "ModelShape":
        """Contents of the file, in its own units and frame; raises ValueError if it cannot be read."""
        from mjsim.models import read_model

        return read_model(self.model, self._read)

    def _read(self, path: str) -> bytes:
        return read_asset(path, self._source)


def shape_in(context: dict[str, Any], model: str, read: Callable[[str], bytes]) -> "ModelShape":
    """Return the contents of a file, read once for all items of a world, even if it is broken.

    Args:
        context: Of the validation of the world; what was read is kept in it.
        model: Path of the file, as the world has it.
        read: Where files come from.

    Raises:
        PydanticCustomError: The file cannot be read; a sentence about the key 'model'.
    """
    from mjsim.models import read_model

    known: dict[str, ModelShape | str] = context.setdefault("models", {})
    if model not in known:
        try:
            known[model] = read_model(model, read)
        except ValueError as error:
            known[model] = str(error)
    shape = known[model]
    if isinstance(shape, str):
        raise fault(shape, "model")
    return shape
