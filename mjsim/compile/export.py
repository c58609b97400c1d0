"""A scene as files that plain MuJoCo loads, with nothing of mjsim there."""

from pathlib import Path

from mjsim.compile.scene import compile_world
from mjsim.errors import UsageError
from mjsim.world.model import World


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
