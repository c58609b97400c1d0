"""Files of MJCF and URDF that items of a world name."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from mjsim.world.ground import fault

if TYPE_CHECKING:  # and below where it is used: worlds without models start without it
    from mjsim.models import ModelShape


def shape_in(context: dict[str, Any], model: str, read: Callable[[str], bytes]) -> "ModelShape":
    """Return what a file holds, read once for all items of a world, also when it is broken.

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
