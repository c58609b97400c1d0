"""Appearance of objects from files: their colours, and their materials rebuilt in the scene."""

from typing import Any

import mujoco
import numpy as np

from mjsim.compile.geom_looks import is_flat, rgba_of, texture_of
from mjsim.compile.textures import add_material, add_picture, color_of
from mjsim.geometry import Array
from mjsim.interface import Picture
from mjsim.models import UNSAID

GRAY = [128 / 255, 128 / 255, 128 / 255, 1.0]
"""Colour of geoms without a colour in the file."""
WHITE = 255
CUBE_SIDES = "RLUDFB......"
"""Right, left, up, down, front and back, one below the other; the rest is blank: MuJoCo writes twelve letters into the
file of a scene, and reads them for as many fields alone."""


class LookOf:
    """Materials of one file, which are added to the scene when a geom first uses them."""

    def __init__(self, spec: mujoco.MjSpec, model: mujoco.MjModel, key: str) -> None:
        """Keep the scene and the file.

        Args:
            spec: The scene.
            model: The file as compiled by MuJoCo.
            key: Prefix of the names of its materials in the scene.
        """
        self._spec, self._model, self._key = spec, model, key
        self._names: dict[int, str] = {}
        self._means: dict[int, Array] = {}

    def of_geom(self, number: int, *, plain: str | None) -> dict[str, Any]:
        """Return material and colour of a geom.

        Args:
            number: Number of the geom in the file.
            plain: Colour '#rrggbb' in place of its own; None for its own.
        """
        rgba = self._model.geom_rgba[number].tolist()
        material = int(self._model.geom_matid[number])
        if plain is not None:
            return {"material": "matte", "rgba": color_of(plain)}
        if material >= 0:
            return {"material": self._material(material), "rgba": rgba}
        return {"material": "matte", "rgba": GRAY if rgba == UNSAID else rgba}

    def tile(self, number: int) -> float | None:
        """Return the size of a tile of a flat texture that a geom repeats in units of length; None for others."""
        model, material, texture = self._model, int(self._model.geom_matid[number]), texture_of(self._model, number)
        if texture < 0 or not model.mat_texuniform[material]:
            return None
        return 1.0 / float(model.mat_texrepeat[material][0]) if is_flat(model, texture) else None

    def metric(self, name: str) -> str:
        """Return a material for meshes with texture coordinates: MuJoCo would repeat the original by their size."""
        metric = f"{name}/metric"
        if self._spec.material(metric) is None:
            source, material = self._spec.material(name), self._spec.add_material(name=metric)
            material.textures, material.rgba = list(source.textures), source.rgba
            material.emission, material.reflectance = source.emission, 0.0
            material.specular, material.shininess = source.specular, source.shininess
        return metric

    def mean(self, number: int) -> list[float]:
        """Return the mean colour of a geom with a flat texture."""
        texture = texture_of(self._model, number)
        if texture not in self._means:
            self._means[texture] = self._picture(texture).mean(axis=(0, 1)) / WHITE
        return [float(value) for value in rgba_of(self._model, number) * [*self._means[texture], 1.0]]

    def _material(self, number: int) -> str:
        if number not in self._names:
            self._names[number] = f"{self._key}/look{number + 1}"
            self._add(number, self._names[number])
        return self._names[number]

    def _add(self, number: int, name: str) -> None:
        model = self._model
        texture = int(model.mat_texid[number][mujoco.mjtTextureRole.mjTEXROLE_RGB])
        if texture < 0:
            material = self._spec.add_material(name=name)
        elif is_flat(model, texture):
            add_material(self._spec, name, self._picture(texture))
            material = self._spec.material(name)
        else:
            material = self._add_cube(name, self._picture(texture))
        material.rgba = model.mat_rgba[number]
        material.emission, material.specular = model.mat_emission[number], model.mat_specular[number]
        material.shininess, material.reflectance = model.mat_shininess[number], 0.0
        material.texuniform, material.texrepeat = bool(model.mat_texuniform[number]), model.mat_texrepeat[number]

    def _add_cube(self, name: str, sides: Picture) -> mujoco.MjsMaterial:
        """Add a material with a cube map: a picture on each side."""
        texture = add_picture(self._spec, name, sides, mujoco.mjtTexture.mjTEXTURE_CUBE)
        texture.gridsize, texture.gridlayout = [len(CUBE_SIDES), 1], CUBE_SIDES
        material = self._spec.add_material(name=name)
        material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = name
        return material

    def _picture(self, texture: int) -> Picture:
        """Return RGB, shape (height, width, 3)."""
        model = self._model
        height, width, channels = (
            int(sizes[texture]) for sizes in (model.tex_height, model.tex_width, model.tex_nchannel)
        )
        first = int(model.tex_adr[texture])
        pixels = model.tex_data[first : first + height * width * channels].reshape(height, width, channels)
        if channels == 1:
            pixels = np.repeat(pixels, 3, axis=2)
        return np.ascontiguousarray(pixels[..., :3])
