"""MJCF and URDF files named by items of a world."""

from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Any, Self

from pydantic import Field, PrivateAttr, ValidationInfo, model_validator

from mjsim.world.files import BUILT, Source, read_asset
from mjsim.world.ground import Model, ModelPath, fault

if TYPE_CHECKING:  # Imported again where it is used, so that worlds that do not need it load faster.
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
            # Items of one file share one reading of it.
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
        context: Validation context of the world, which caches files.
        model: Path of the file, as written in the world.
        read: Reads files.

    Raises:
        PydanticCustomError: The file cannot be read; the message is about the key 'model'.
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
