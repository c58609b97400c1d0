"""Files of a robot or an arm, as published by manufacturers: a faulty mesh or picture is left out and reported."""

import posixpath
from collections.abc import Iterator

from mjsim.inventory import Fate, FileItem
from mjsim.models.mesh_files import is_small_stl, with_volume
from mjsim.models.model_sources import Element, Gatherer, Read
from mjsim.models.obj_repair import mended_obj
from mjsim.models.robot_meshes import PlainMeshes

NOUNS = {"mesh": "mesh", "texture": "picture"}
INSTEAD = {"mesh": "collision shapes are used instead", "texture": "plain colours are used instead"}
"""Replacement of a file that is left out."""


class LenientGatherer(Gatherer):
    """Reads the files of a description; leaves out faulty ones, and converts meshes to forms that MuJoCo reads."""

    def __init__(self, path: str, read: Read, *, up_axis: bool = True, guarded: bool = False) -> None:
        """Store functions; the arguments are those of `Gatherer` and of `PlainMeshes`."""
        super().__init__(path, read)
        self._amiss: list[FileItem] = []
        self._meshes = PlainMeshes(self._original, self._gone, up_axis=up_axis, guarded=guarded)
        self._urdf = False
        self.missing: set[str] = set()
        """Names in the text that stand for files that are left out."""

    def _original(self, name: str) -> bytes:
        """Return a file by its name in the description, unchanged."""
        return super().file(self._resolved(name))

    def file(self, path: str) -> bytes:
        """Return a file; in URDF, meshes are converted to forms that MuJoCo reads."""
        data = super().file(path)
        if not path.lower().endswith(".stl"):
            return mended_obj(data) if self._urdf and path.lower().endswith(".obj") else data
        if not is_small_stl(data):
            try:
                data = self._meshes.plain(path, data)
            except ValueError:
                return data  # Faults are reported when it is checked.
        # In MJCF, a mesh without volume gets its mass from its surface; URDF states the mass.
        return with_volume(data) if self._urdf else data

    def keep_urdf(self, root: Element) -> None:
        """Keep the parts of a URDF that make up an object, with meshes that MuJoCo reads."""
        self._urdf = True
        self._meshes.put_into(root)
        super().keep_urdf(root)

    def asset(self, name: str, kind: str, *, variant: str = "") -> str:
        """Read a mesh or a texture; for a faulty one return a name in `missing`."""
        if name in self.missing:
            return name
        try:
            if name in self._meshes.made:
                return self.store(self._meshes.made[name], kind, variant)
            return super().asset(name, kind, variant=variant)
        except ValueError as error:
            if "more than" in str(error) and "the files of" in str(error):
                raise
            return self._gone(name, error, kind)

    def _gone(self, name: str, error: ValueError, kind: str = "mesh") -> str:
        """Note a faulty mesh or texture, and return its replacement."""
        self._amiss.append(_left_out(name, str(error), kind))
        flat = f"gone-{len(self.missing)}"
        self.missing.add(flat)
        return flat

    def items(self) -> Iterator[FileItem]:
        """Yield what was left out or simplified."""
        for name in sorted(self._meshes.coarser):
            yield FileItem(Fate.MENDED, "mesh", posixpath.basename(name), "simplified, as it has too many corners")
        for name in sorted(self._meshes.bare):
            yield FileItem(
                Fate.LEFT_OUT, "look of mesh", posixpath.basename(name), "an arm shows no pictures of meshes"
            )
        for name in sorted(self._meshes.absent):
            kind = "file of colours" if name.lower().endswith(".mtl") else "picture"
            yield FileItem(Fate.LEFT_OUT, f"missing {kind}", posixpath.basename(name), INSTEAD["texture"])
        yield from self._amiss


def _left_out(name: str, error: str, kind: str) -> FileItem:
    """Return why a mesh or a texture is left out."""
    noun, called, instead = NOUNS[kind], posixpath.basename(name), INSTEAD[kind]
    if "convert it to OBJ" in error:
        ending = name.rpartition(".")[2].lower() if "." in name else "?"
        return FileItem(Fate.LEFT_OUT, noun, called, f"a format that cannot be read (.{ending}); {instead}")
    if "corners" in error and "simplify" in error:
        return FileItem(Fate.LEFT_OUT, noun, called, f"too many corners; {instead}")
    if any(word in error for word in ("cannot be read", "a damaged", "a truncated", "is not a PNG", "megapixels")):
        return FileItem(Fate.LEFT_OUT, f"broken {noun}", called, instead)
    return FileItem(
        Fate.LEFT_OUT, f"missing {noun}", called, f"{error}; {instead}" if "lies outside" in error else instead
    )
