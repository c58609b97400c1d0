"""Information about a world for modules: its beacons, and its map."""

from mjsim.interface import BeaconInfo, MarkerInfo, Picture, WorldMap
from mjsim.world import World, hung, segments


def catalogue_of(world: World) -> dict[str, BeaconInfo]:
    """Return the catalogue entry of each beacon, by name."""
    pictures: dict[str, Picture] = {}
    known = world.run.map == "known"
    catalogue = {}
    for item in hung(world):
        beacon, marker, picture = item.beacon, item.beacon.marker, None
        if beacon.image is not None:
            if beacon.image not in pictures:
                pictures[beacon.image] = world.read_picture(beacon.image)
            picture = pictures[beacon.image]
        rows, columns = (1, 1) if picture is None else picture.shape[:2]
        catalogue[beacon.name] = BeaconInfo(
            name=beacon.name,
            picture=picture,
            width=beacon.width,
            height=beacon.width * rows / columns,
            pose=item.place if known and item.fixed else None,
            center=item.center if known and item.fixed else None,
            marker=MarkerInfo(marker.dictionary, marker.id) if marker is not None else None,
            anchor=beacon.anchor,
        )
    return catalogue


def map_of(world: World) -> WorldMap:
    """Return the walls, the obstacles and the poses of the beacons."""
    beacons = {item.beacon.name: item.place for item in hung(world) if item.fixed}
    return WorldMap(segments=segments(world), beacons=beacons)
