"""Colours and textures of visuals of SDF: albedo maps, scripts of materials (OGRE), and the materials of Gazebo."""

import re
from collections.abc import Mapping
from pathlib import Path, PurePosixPath
from xml.etree.ElementTree import Element

from mjsim.errors import UsageError
from mjsim.exchange.bounded_file import read_bounded
from mjsim.exchange.scenes.scene_meshes import MAX_SIDE
from mjsim.exchange.scenes.scene_solids import Scene, SceneTexture
from mjsim.exchange.scenes.sdf_files import Folders
from mjsim.inventory import Fate
from mjsim.models import bounded, color_of, encode_png, hex_of, picture_size, read_picture

MAX_SCRIPT, MAX_PICTURE = 2_000_000, 40_000_000
"""Maximum size of a file with materials, and of a picture [bytes]."""
STOCK: Mapping[str, str] = {
    "wood": "materials/wood.jpg",
    "woodfloor": "materials/boards.jpg",
    "woodpallet": "materials/boards.jpg",
    "bricks": "materials/brick.jpg",
    "ceilingtiled": "materials/ceiling_panels.jpg",
    "paintedwall": "materials/plaster_white.jpg",
    "carpet": "materials/carpet.jpg",
}
"""Materials of Gazebo, without 'Gazebo/' -> a texture of mjsim that resembles it."""
_MATERIAL = r"^\s*material\s+\"?{}\"?\s*(?::[^{{\n]*)?\s*\{{"
_TEXTURE = re.compile(r"(?:^|[\s{])texture\s+\"?([^\s\"]+)")
_DIFFUSE = re.compile(r"(?:^|[\s{])diffuse\s+([0-9.eE+-]+)\s+([0-9.eE+-]+)\s+([0-9.eE+-]+)")

Look = tuple[str | None, SceneTexture | None]
"""Colour, '#rrggbb', and picture."""


class SdfLooks:
    """Finds the looks of visuals."""

    def __init__(self, scene: Scene, folders: Folders) -> None:
        self._scene, self._folders = scene, folders
        self._known: dict[Path, SceneTexture | None] = {}
        self._told: set[str] = set()

    def of_visual(self, visual: Element, file: Path, name: str) -> Look:
        """Return the look of a visual in an SDF file; `name` is that of its model."""
        color = color_of(visual)
        albedo = (visual.findtext(".//albedo_map") or "").strip()
        if albedo:
            return color or ("#ffffff" if self._picture(albedo, file, name) else None), self._picture(
                albedo, file, name
            )
        script = visual.find("material/script")
        if script is None:
            return color, None
        return self._of_script(script, color, file, name)

    def _of_script(self, script: Element, color: str | None, file: Path, name: str) -> Look:
        material = (script.findtext("name") or "").strip()
        uris = [(uri.text or "").strip() for uri in script.findall("uri")]
        places = [place for uri in uris if (place := self._folders.find(uri, file.parent)) is not None]
        block = next((found for text in self._scripts(places) if (found := _block(text, material))), "")
        if block:
            picture, diffuse = _TEXTURE.search(block), _DIFFUSE.search(block)
            shown = None if picture is None else self._picture_in(picture[1], places, name)
            own = None if diffuse is None else _hex(diffuse.groups())
            return own or color or ("#ffffff" if shown else None), shown
        stock = STOCK.get(material.rpartition("/")[2].lower())
        if stock is not None:
            self._tell(Fate.GUESSED, f"material {material}", name, f"the texture {stock} of mjsim")
            return "#ffffff", SceneTexture(stock)
        if color is None and material:
            self._tell(Fate.LEFT_OUT, f"material {material}", name, "not found; the usual colour")
        return color, None

    def _scripts(self, places: list[Path]) -> list[str]:
        """Return the texts of the files with materials at some places."""
        files = [file for place in places for file in (sorted(place.glob("*.material")) if place.is_dir() else [place])]
        texts = []
        for file in files:
            try:
                texts.append(read_bounded(file, limit=MAX_SCRIPT, kind="a script").decode(errors="replace"))
            except UsageError as error:
                self._tell(Fate.LEFT_OUT, "script of materials", file.name, str(error))
        return texts

    def _picture_in(self, named: str, places: list[Path], name: str) -> SceneTexture | None:
        """Return the picture that a script names, which is beside it or in the folder of textures."""
        folders = [place if place.is_dir() else place.parent for place in places]
        for folder in (*folders, *(folder.parent / "textures" for folder in folders)):
            if (folder / named).is_file():
                return self._picture(str(folder / named), folder / named, name)
        self._tell(Fate.LEFT_OUT, "texture", named, "not found")
        return None

    def _picture(self, uri: str, file: Path, name: str) -> SceneTexture | None:
        place = self._folders.find(uri, file.parent)
        if place is None or not place.is_file():
            self._tell(Fate.LEFT_OUT, "texture", uri, "not found")
            return None
        if place not in self._known:
            self._known[place] = self._read(place)
        return self._known[place]

    def _read(self, place: Path) -> SceneTexture | None:
        try:
            data = read_bounded(place, limit=MAX_PICTURE, kind="a picture")
            picture_size(data)
            picture = encode_png(bounded(read_picture(data), MAX_SIDE))
        except (UsageError, ValueError) as error:
            self._tell(Fate.LEFT_OUT, "texture", place.name, str(error))
            return None
        stem = re.sub(r"[^A-Za-z0-9_-]+", "_", PurePosixPath(place.name).stem)[:40] or "texture"
        return SceneTexture(f"{stem}_{len(self._known)}.png", picture)

    def _tell(self, fate: Fate, kind: str, name: str, why: str) -> None:
        if f"{kind} {name} {why}" not in self._told:
            self._told.add(f"{kind} {name} {why}")
            self._scene.tell(fate, kind, name, why)


def _block(text: str, material: str) -> str:
    """Return the text between the braces of a material in a script; '' if the material is missing."""
    head = re.search(_MATERIAL.format(re.escape(material)), text, re.MULTILINE)
    if head is None:
        return ""
    depth, start = 1, head.end()
    for match in re.finditer(r"[{}]", text[start:]):
        depth += 1 if match[0] == "{" else -1
        if depth == 0:
            return text[start : start + match.start()]
    return text[start:]


def _hex(words: tuple[str, ...]) -> str | None:
    try:
        return hex_of(float(word) for word in words)
    except ValueError:
        return None
