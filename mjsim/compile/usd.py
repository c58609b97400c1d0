"""A scene as USD, which Omniverse, Blender and Houdini read: MuJoCo's own exporter writes it, through usd-core."""

import re
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import mujoco

from mjsim.compile.mujoco_model import compiled
from mjsim.compile.scene import compile_world
from mjsim.errors import UsageError, how_to_install
from mjsim.output import require_free, write_files
from mjsim.sentences import Sentence
from mjsim.world import World

SUFFIXES = (".usda", ".usdc", ".usd")
"""Suffixes of files."""
MAX_SHAPES = 100_000
"""Largest number of shapes for the exporter."""
FACETS = 24
"""Facets around a round shape; the exporter's own 100 by 100 take 1 MB for each roller of a wheel."""


def write_usd(world: World, path: str | Path, *, overwrite: bool = False) -> Path:
    """Write the scene of a world at the start, including robots, and return the path of the file.

    Args:
        world: The world.
        path: File name that ends in .usda (text), .usdc or .usd; pictures are written to `NAME_pictures` beside it.
        overwrite: Whether to replace existing files.

    Raises:
        UsageError: usd-core is not installed, the suffix is another one, or a file exists or cannot be written.
    """
    path = Path(path)
    if path.suffix not in SUFFIXES:
        raise UsageError(
            Sentence(
                "'{path}' ends in '{suffix}'; a USD file ends in {suffixes}", path, path.suffix, ", ".join(SUFFIXES)
            )
        )
    require_free(path, overwrite=overwrite)
    try:
        from mujoco.usd.exporter import USDExporter
        from pxr import Tf, UsdGeom
    except ImportError:
        raise UsageError(
            Sentence(
                "USD is written by usd-core, which is not installed; type: {how_to_install}", how_to_install("usd-core")
            )
        ) from None
    model = compiled(_plainly_named(compile_world(world)))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    pictures = f"{path.stem}_pictures"
    with tempfile.TemporaryDirectory() as folder:
        exporter = USDExporter(
            model, max_geom=MAX_SHAPES, output_directory="usd", output_directory_root=folder, verbose=False
        )
        try:
            files = {
                f"{pictures}/{file.name}": file.read_bytes() for file in (Path(folder) / "usd" / "assets").iterdir()
            }
            exporter.texture_files = [f"{pictures}/{Path(file).name}" for file in exporter.texture_files]
            with _coarsely_round():
                exporter.update_scene(data)
            UsdGeom.SetStageMetersPerUnit(exporter.stage, 1.0)
            _type_varnames(exporter.stage)
            whole = Path(folder) / f"whole{path.suffix}"
            exporter.stage.Export(str(whole))
            files[path.name] = whole.read_bytes()
        except Tf.ErrorException as error:
            raise UsageError(
                Sentence("cannot write '{path}': {text}", path, str(error).strip().splitlines()[-1].strip())
            ) from error
    write_files(path.parent, files, overwrite=overwrite)
    return path


@contextmanager
def _coarsely_round() -> Iterator[None]:
    """Make the exporter use fewer facets for round shapes; it has no setting for that."""
    from mujoco.usd import shapes

    finely = shapes.mesh_factory
    shapes.mesh_factory = partial(finely, resolution=FACETS)
    try:
        yield
    finally:
        shapes.mesh_factory = finely


def _type_varnames(stage: Any) -> None:
    """Make the names of texture coordinates strings, as UsdPreviewSurface requires; the exporter writes tokens."""
    from pxr import Sdf, UsdShade

    for prim in stage.Traverse():
        name = UsdShade.Shader(prim).GetInput("varname") if prim.IsA(UsdShade.Shader) else None
        if name:
            value = name.Get()
            prim.RemoveProperty(name.GetFullName())
            UsdShade.Shader(prim).CreateInput("varname", Sdf.ValueTypeNames.String).Set(str(value))


def _plainly_named(spec: mujoco.MjSpec) -> mujoco.MjSpec:
    """Return a scene whose shapes have valid names in USD: letters, digits and underscores."""
    taken = {geom.name for geom in spec.geoms}
    for geom in spec.geoms:
        name = re.sub(r"\W", "_", geom.name)
        while name != geom.name and name in taken:
            name += "_"
        taken.add(name)
        geom.name = name
    return spec
