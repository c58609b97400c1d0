"""Exports a scene as files that MuJoCo loads without mjsim."""

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import mujoco

from mjsim.compile.mujoco_model import compiled
from mjsim.compile.scene import compile_world
from mjsim.compile.textures import picture_files
from mjsim.output import free_paths, write_files
from mjsim.world import World

DIGITS = 15
"""Significant digits of numbers in the file: the maximum for which 0.1 is written as 0.1."""


def export_scene(world: World, folder: str | Path, *, overwrite: bool = False) -> Path:
    """Write `scene.xml` and `assets/` of a world into a folder, and return the path of `scene.xml`.

    Nothing is written when the world cannot be compiled. With `overwrite` the files of an earlier scene are replaced;
    all others in the folder stay.

    Raises:
        UsageError: A file exists, or cannot be written.
    """
    free_paths(folder, ("scene.xml",), overwrite=overwrite)
    spec = compile_world(world)
    compiled(spec)
    spec.meshdir = spec.texturedir = "assets"
    with _written_with(DIGITS):
        text = spec.to_xml()
    files = {f"assets/{name}": data for name, data in (spec.assets | picture_files(spec)).items()}
    write_files(folder, files | {"scene.xml": text.encode()}, overwrite=overwrite)
    return Path(folder) / "scene.xml"


@contextmanager
def _written_with(digits: int) -> Iterator[None]:
    """Set the number of digits that MuJoCo writes; its default of six would move a distant wall by a millimetre.

    The setting exists for MuJoCo's own bindings only; a MuJoCo without it writes six.
    """
    (path,) = Path(mujoco.__file__).parent.glob("libmujoco.*")
    library = ctypes.CDLL(str(path))
    try:
        get_digits, set_digits = library._mjPRIVATE__get_xml_precision, library._mjPRIVATE__set_xml_precision
    except AttributeError:
        yield
        return
    before = get_digits()
    set_digits(digits)
    try:
        yield
    finally:
        set_digits(before)
