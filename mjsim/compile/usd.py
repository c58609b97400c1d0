"""A scene as USD, which Omniverse, Blender and Houdini read: MuJoCo's own exporter writes it, through usd-core."""

import re
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import mujoco

from mjsim.compile.scene import compile_world
from mjsim.errors import UsageError
from mjsim.world.model import World

KINDS = (".usda", ".usdc", ".usd")
"""Names of files end so."""
MOST_SHAPES = 100_000
"""That the exporter makes room for."""
FACETS = 24
"""Around a round shape; the exporter's own hundred by hundred make 1 MB of each roller of a wheel."""


def write_usd(world: World, path: str | Path) -> Path:
    """Write the scene of a world as it stands at the start, robots too, and return the path of the file.

    Args:
        world: What is to be written.
        path: Ends in .usda (text), .usdc or .usd; pictures come into `NAME_pictures` beside it.

    Raises:
        UsageError: usd-core is not installed, the name ends otherwise, or the file cannot be written.
    """
    path = Path(path)
    if path.suffix not in KINDS:
        raise UsageError(f"'{path}' ends in '{path.suffix}'; a USD file ends in {', '.join(KINDS)}")
    try:
        from mujoco.usd.exporter import USDExporter
        from pxr import Tf, UsdGeom
    except ImportError:
        raise UsageError("USD is written by usd-core, which is not installed; install 'mjsim[usd]'") from None
    model = _plainly_named(compile_world(world)).compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    pictures = path.parent / f"{path.stem}_pictures"
    with tempfile.TemporaryDirectory() as folder:
        exporter = USDExporter(
            model, max_geom=MOST_SHAPES, output_directory="usd", output_directory_root=folder, verbose=False
        )
        try:
            pictures.mkdir(parents=True, exist_ok=True)
            for file in (Path(folder) / "usd" / "assets").iterdir():
                shutil.copy(file, pictures / file.name)
            exporter.texture_files = [f"{pictures.name}/{Path(file).name}" for file in exporter.texture_files]
            with _coarsely_round():
                exporter.update_scene(data)
            UsdGeom.SetStageMetersPerUnit(exporter.stage, 1.0)
            exporter.stage.Export(str(path))
        except OSError as error:
            raise UsageError(f"cannot write '{error.filename or path}': {error.strerror}") from error
        except Tf.ErrorException as error:
            raise UsageError(f"cannot write '{path}': {str(error).strip().splitlines()[-1].strip()}") from error
    return path


@contextmanager
def _coarsely_round() -> Iterator[None]:
    """Let the exporter make round shapes of fewer facets; it has no setting for that."""
    from mujoco.usd import shapes

    finely = shapes.mesh_factory
    shapes.mesh_factory = partial(finely, resolution=FACETS)
    try:
        yield
    finally:
        shapes.mesh_factory = finely


def _plainly_named(spec: mujoco.MjSpec) -> mujoco.MjSpec:
    """Return a scene whose shapes have names that USD takes: letters, digits and underscores."""
    taken: set[str] = set()
    for geom in spec.geoms:
        if geom.name:
            name = re.sub(r"\W", "_", geom.name)
            while name in taken:
                name += "_"
            taken.add(name)
            geom.name = name
    return spec
