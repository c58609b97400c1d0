"""Pictures of markers, and the textures and materials that show pictures in a scene."""

import cv2
import mujoco
import numpy as np

from mjsim.interface import Picture
from mjsim.models import encode_png
from mjsim.world import QUIET, Ceiling, Floor, FloorPatch, Obstacle, Wall, modules_across

MAX_BEACON_SIDE = 640
"""Longest side of a beacon's texture [px]: more is invisible at 640 x 480 and does not improve the detection of
pictures."""
MAX_TILE_SIDE = 1024
"""Longest side of a floor or wall texture [px]."""
MARKER_SIDE = 384
"""Approximate side of a marker's texture with its border [px]; more detail is lost in any image, and less looks blurred
at close range."""
WHITE = 255


def marker_picture(dictionary: str, number: int) -> Picture:
    """Return a marker with its white border, each module a whole number of pixels wide."""
    modules = modules_across(dictionary)
    module = max(MARKER_SIDE // (modules + 2 * QUIET), 1)
    known = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, f"DICT_{_opencv_name(dictionary)}"))
    gray = cv2.aruco.generateImageMarker(known, number, modules * module)
    framed = np.pad(gray, QUIET * module, constant_values=WHITE)
    return np.repeat(framed[..., None], 3, axis=2).astype(np.uint8)


def _opencv_name(dictionary: str) -> str:
    """Return OpenCV's name of a dictionary: '4X4_50', 'ARUCO_ORIGINAL', 'APRILTAG_36h11'."""
    if dictionary.startswith("apriltag_"):
        return dictionary.replace("apriltag", "APRILTAG")
    return {"original": "ARUCO_ORIGINAL", "mip_36h12": "ARUCO_MIP_36h12"}.get(dictionary, dictionary.upper())


def add_material(spec: mujoco.MjSpec, name: str, picture: Picture, *, emission: float = 0.0, gray: float = 1.0) -> None:
    """Add a matte material with a picture; its texture and file have the same name.

    Args:
        spec: The scene to add to.
        name: A path without suffix, unique in the scene.
        picture: RGB.
        emission: Its own light, as a multiple of `gray`.
        gray: Reflectance.
    """
    add_picture(spec, name, picture, mujoco.mjtTexture.mjTEXTURE_2D)
    material = add_matte(spec, name)
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = name
    material.emission = emission
    material.rgba = [gray, gray, gray, 1.0]


def add_picture(spec: mujoco.MjSpec, name: str, picture: Picture, kind: mujoco.mjtTexture) -> mujoco.MjsTexture:
    """Add a texture and return it; it holds the pixels, and names the file that `picture_files` makes of them.

    To make a PNG of each, which MuJoCo reads again, would take most of the time of a room with many pictures.
    """
    texture = spec.add_texture(
        name=name, type=kind, file=f"{name}.png", colorspace=mujoco.mjtColorSpace.mjCOLORSPACE_LINEAR
    )
    texture.height, texture.width, texture.nchannel = picture.shape
    texture.data = picture.tobytes()
    return texture


def picture_files(spec: mujoco.MjSpec) -> dict[str, bytes]:
    """Return a PNG for each texture that holds pixels, by the name of the file that the texture names."""
    return {texture.file: encode_png(_file_pixels(texture)) for texture in spec.textures if texture.data}


def _file_pixels(texture: mujoco.MjsTexture) -> Picture:
    """Return the pixels of a texture, those of a cube with the blank fields that its file has below."""
    pixels = np.frombuffer(bytes(texture.data), np.uint8).reshape(texture.height, texture.width, 3)
    fields = int(texture.gridsize[0]) if texture.type == mujoco.mjtTexture.mjTEXTURE_CUBE else 0
    return np.pad(pixels, ((0, max(fields * texture.width - texture.height, 0)), (0, 0), (0, 0)))


def add_matte(spec: mujoco.MjSpec, name: str) -> mujoco.MjsMaterial:
    """Add a matte white material: one tone per face, at any angle."""
    return spec.add_material(name=name, specular=0.0, shininess=0.0, reflectance=0.0)


def color_of(text: str, *, alpha: float = 1.0) -> list[float]:
    """Return red, green, blue and alpha in [0, 1] of '#rrggbb'."""
    return [int(text[i : i + 2], 16) / 255 for i in (1, 3, 5)] + [alpha]


def tint_of(item: Wall | FloorPatch | Floor | Ceiling | Obstacle) -> str:
    """Return the colour that multiplies the texture of an item: its own, white where it keeps the default."""
    color = item.color
    return "#ffffff" if color == type(item).model_fields["color"].default else color
