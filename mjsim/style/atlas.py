"""The texture atlas: one picture with all small things, and the position of each."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.models import read_picture
from mjsim.style.atlas_faces import Quad
from mjsim.world import BUILT, read_asset

FOLDER = "style"
INSET_PIXELS = 0.5
"""Distance of texture coordinates from the edge of a part, so that no neighbour bleeds in [px]."""


@dataclass(frozen=True, slots=True, eq=False)
class PartAtlas:
    """A picture with named parts."""

    picture: NDArray[np.uint8]
    """RGB, shape (height, width, 3)."""
    parts: Mapping[str, tuple[int, int, int, int]]
    """Left, top, width and height of each [px]."""

    def texcoords(self, faces: Sequence[Quad]) -> Array:
        """Return the texture coordinates of the corners of faces, right and down in [0, 1], shape (n, 4, 2)."""
        height, width = self.picture.shape[:2]
        places = np.array([self.parts[face.part] for face in faces], dtype=float).reshape(-1, 4)
        share = np.array([face.share for face in faces]).reshape(-1, 1)
        left, right = places[:, :1] + INSET_PIXELS, places[:, :1] + places[:, 2:3] * share - INSET_PIXELS
        top, bottom = places[:, 1:2] + INSET_PIXELS, places[:, 1:2] + places[:, 3:] - INSET_PIXELS
        x = np.concatenate([left, right, right, left], axis=1) / width
        y = np.concatenate([bottom, bottom, top, top], axis=1) / height
        return np.stack([x, y], axis=2)


def read_atlas() -> PartAtlas:
    """Return the atlas that comes with mjsim."""
    places = json.loads(read_asset(f"{FOLDER}/atlas.json", BUILT))
    picture = read_picture(read_asset(f"{FOLDER}/atlas.jpg", BUILT))
    return PartAtlas(picture, {name: tuple(place) for name, place in places.items()})
