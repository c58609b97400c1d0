"""Files that SDF names: models in folders with a model.config, meshes beside them."""

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree.ElementTree import Element, ParseError, fromstring

from mjsim.errors import UsageError
from mjsim.exchange.bounded_file import read_bounded
from mjsim.models import RefusedXmlError, checked_xml, sdf_named_in

MAX_XML = 50_000_000
"""Maximum size of a file [bytes]."""
MAX_PARENTS = 4
"""Number of folders above the file in which models are searched."""
MODEL_FOLDERS, MANIFESTS = ("models", "worlds", "meshes", "materials"), ("model.config", "package.xml", "manifest.xml")
"""Above the scene's folder, a file is read only in a folder of such a name, or in one that holds such a file."""
STAGE = re.compile(rb'^[^#<\n]{0,99}\bbitmap\s+"([^"\n]{1,200})"', re.MULTILINE)
"""The map of a world of Stage, by which it is recognised."""


def read_xml(path: Path) -> Element:
    """Return the root of an XML file.

    Raises:
        UsageError: The file does not exist, is too large, or is not XML.
    """
    data = read_bounded(path, limit=MAX_XML, kind="an SDF file")
    try:
        return fromstring(checked_xml(data, deepest=200))
    except RefusedXmlError as error:
        raise UsageError(f"'{path}' {error}") from None
    except ParseError as error:
        if found := STAGE.search(data):
            way = f"bring in its map by mjsim new --from {found[1].decode(errors='replace')} --scale METRES"
            raise UsageError(f"'{path}' is a world of Stage, which mjsim does not read; {way}") from None
        what = (
            "; correct it" if data.lstrip(b"\xef\xbb\xbf \t\r\n")[:1] == b"<" else ", and so no world of Gazebo (SDF)"
        )
        raise UsageError(f"'{path}' is not XML: {error}{what}") from None


@dataclass(slots=True)
class Folders:
    """Finds what `model://NAME`, `package://NAME` and relative names refer to."""

    path: Path
    """The file with the scene."""
    search: Sequence[Path]
    """Folders of models that the user has named."""
    _models: dict[Path, Element] = field(default_factory=dict)

    def find(self, uri: str, beside: Path) -> Path | None:
        """Return the path of a file or folder; None if it is missing.

        Args:
            uri: URI as written.
            beside: Folder of the file that names it.
        """
        kind, sign, rest = uri.strip().partition("://")
        if not sign:
            # Gazebo also accepts a bare name as that of a model.
            return self._existing(beside / kind) or self._among_models(kind)
        if kind in ("http", "https"):
            # A model from a server, if there is a local copy with its name.
            kind, rest = "model", rest.rstrip("/").rpartition("/")[2]
        if kind not in ("model", "package", "file"):
            return None
        if kind == "file" and (found := self._existing(beside / rest.lstrip("/"))):
            return found
        return self._among_models(rest)

    def _among_models(self, name: str) -> Path | None:
        return next((found for folder in self._around() if (found := self._existing(folder / name))), None)

    def _around(self) -> list[Path]:
        """Return the folders in which folders of models may be."""
        above = [self.path.absolute().parent, *self.path.absolute().parents[1 : MAX_PARENTS + 1]]
        return [*self.search, *(place for folder in above for place in (folder / "models", folder))]

    def _existing(self, path: Path) -> Path | None:
        """Return a file or folder that exists below the folders that may be read, links followed; None otherwise."""
        above = self.path.absolute().parents
        roots = [above[min(MAX_PARENTS, len(above) - 1)], *self.search]
        try:
            place = Path(os.path.realpath(path))
            inside = any(place.is_relative_to(os.path.realpath(root)) for root in roots)
            return place if inside and self._is_of_models(place) and place.exists() else None
        except (OSError, ValueError):
            return None

    def _is_of_models(self, place: Path) -> bool:
        """Return whether a place is below the scene, in a folder that the user named, or in a folder of models."""
        if any(place.is_relative_to(os.path.realpath(root)) for root in (self.path.absolute().parent, *self.search)):
            return True
        top = Path(os.path.realpath(self.path.absolute().parents[0]))
        shared = {*top.parents}
        own = [folder for folder in (place, *place.parents) if folder not in shared]
        packages = [folder for folder in place.parents if folder in shared][:MAX_PARENTS]
        return any(folder.name in MODEL_FOLDERS for folder in own) or any(
            (folder / name).is_file() for folder in (*own, *packages) for name in MANIFESTS
        )

    def model_file(self, place: Path) -> Path:
        """Return the SDF file of a model's folder, as its model.config names it; or the file itself.

        Raises:
            UsageError: The folder has no SDF file.
        """
        if place.is_file():
            return place
        for name in [*_sdf_named_in(place / "model.config"), "model.sdf"]:
            if name and (found := self._existing(place / name)) and found.is_file():
                return found
        raise UsageError(f"'{place}' has no model.sdf; name one in its model.config")

    def read(self, path: Path) -> Element:
        """Return the root of an SDF file, parsed once."""
        if path not in self._models:
            self._models[path] = read_xml(path)
        return self._models[path]


def _sdf_named_in(config: Path) -> list[str]:
    """Return the SDF files that a model.config names; none if it is missing or broken."""
    try:
        return sdf_named_in(read_xml(config)) if config.is_file() else []
    except UsageError:
        return []
