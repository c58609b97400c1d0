"""The image on a beacon, as a file for other programs."""

from dataclasses import dataclass

import numpy as np

from mjsim.compile import MAX_BEACON_SIDE, marker_picture
from mjsim.models import bounded, encode_png
from mjsim.world import Beacon, World, printed_share


@dataclass(frozen=True, slots=True)
class BeaconFace:
    """The face of a beacon."""

    file: str
    """File name."""
    png: bytes
    size: tuple[float, float]
    """Width and height, for a marker with its white border [m]."""


def shown_of(world: World, beacon: Beacon) -> BeaconFace:
    """Return the image of a beacon; a reflector is white."""
    share = 1.0
    if beacon.marker is not None:
        picture = marker_picture(beacon.marker.dictionary, beacon.marker.id)
        share = printed_share(beacon.marker.dictionary)
    elif beacon.image is not None:
        picture = world.read_picture(beacon.image)
    else:
        picture = np.full((8, 8, 3), 240, dtype=np.uint8)
    high, wide = picture.shape[:2]
    width = beacon.width * share
    png = encode_png(bounded(picture, MAX_BEACON_SIDE))
    return BeaconFace(f"{beacon.name}.png", png, (width, width * high / wide))
