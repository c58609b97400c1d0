"""A scene as files that plain MuJoCo loads, with nothing of mjsim there."""

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import mujoco

from mjsim.compile.scene import compile_world
from mjsim.errors import UsageError
from mjsim.world.model import World

DIGITS = 15
"""Of each number in the file: the most at which 0.1 is written as 0.1."""


def export_scene(world: World, folder: str | Path) -> Path:
    """Write `scene.xml` and `assets/` of a world into a folder, and return the path of `scene.xml`.

    Nothing is written when the world cannot be compiled.

    Raises:
        UsageError: The folder cannot be written.
    """
    spec = compile_world(world)
    spec.compile()
    folder = Path(folder)
    spec.meshdir = spec.texturedir = "assets"
    with _written_with(DIGITS):
        text = spec.to_xml()
    try:
        for name, data in spec.assets.items():
            path = folder / "assets" / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)
        folder.mkdir(parents=True, exist_ok=True)
        scene = folder / "scene.xml"
        scene.write_text(text)
    except OSError as error:
        raise UsageError(f"cannot write '{error.filename or folder}': {error.strerror}") from error
    return scene


@contextmanager
def _written_with(digits: int) -> Iterator[None]:
    """Let MuJoCo write numbers with so many digits, not the six that would move a far wall by a millimetre.

    MuJoCo has this setting for its own bindings only; a MuJoCo without it writes six.
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
