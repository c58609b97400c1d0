"""Readings of models and pictures as the guarded reader tries them."""

from mjsim.models.files import ModelFiles


def picture(data: bytes) -> str | None:
    """Return what is wrong with a picture; None if it can be read."""
    from mjsim.models.pixels import read_picture

    try:
        read_picture(data)
    except ValueError as error:
        return str(error)
    return None


def model(files: ModelFiles) -> str | None:
    """Return why MuJoCo cannot read a model; None if it can."""
    from mjsim.models.reader import compiled

    try:
        compiled(files)
    except ValueError as error:
        return str(error)
    return None
