"""Test reads of models and pictures, run in the guarded reader."""

from mjsim.models.model_sources import ModelFiles


def picture(data: bytes) -> str | None:
    """Return what is wrong with a picture; None if it can be read."""
    from mjsim.models.picture_pixels import read_picture

    try:
        read_picture(data)
    except ValueError as error:
        return str(error)
    return None


def mesh(path: str, data: bytes, whole: bool) -> str | list[tuple[bytes, list[float] | None, bool, bool]]:
    """Return data and colour of each part of a mesh, without pictures and files that it names; or an error.

    Two more values tell whether a part was simplified, and whether such pictures and files exist.
    """
    from mjsim.models.mesh_files import alone, mesh_parts, whole_mesh

    named: list[str] = []

    def refused(name: str) -> bytes:
        named.append(name)
        return alone(name)

    try:
        parts = [whole_mesh(path, data, alone)] if whole else mesh_parts(path, data, refused, pictures=False)
    except ValueError as error:
        return str(error)
    return [
        (part.data, None if part.rgba is None else list(part.rgba), part.coarser, part.bare or bool(named))
        for part in parts
    ]


def model(files: ModelFiles) -> str | None:
    """Return why MuJoCo cannot read a model; None if it can."""
    from mjsim.models.model_reader import compiled

    try:
        compiled(files)
    except ValueError as error:
        return str(error)
    return None
