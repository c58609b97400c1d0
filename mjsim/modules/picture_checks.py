"""Checks the pictures of beacons: whether the cameras of a world can recognise them and tell them apart."""

import hashlib
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import astuple, dataclass
from functools import cache, lru_cache, partial
from importlib import metadata, resources
from pathlib import Path
from typing import Any

from mjsim.errors import Problem
from mjsim.models import note, noted, shown_size
from mjsim.sentences import Sentence
from mjsim.world import Camera, World, problems_at

MIN_RECOGNITION_DISTANCE = 1.0
"""Distance to which at least one camera must recognise a picture [m]."""
CACHE_SIZE = 8
"""Number of sets of pictures whose quality is cached."""


@dataclass(frozen=True, slots=True, kw_only=True)
class JudgedPicture:
    """How well `BeaconVision` recognises the picture of a beacon."""

    least_side: float
    """Smallest size in an image at which it is recognised, the root of its area [px]; infinite if it never is."""
    distance: float
    """Distance to which the camera with the longest focal length recognises it [m]."""
    fault: str | None
    """What is wrong with it and what would be right; None for a good one."""


def check_pictures(world: World) -> list[Problem]:
    """Return the beacons whose pictures the cameras of a world cannot recognise or cannot tell apart."""
    judged = judge_pictures(world)
    faults = (
        (
            ("beacons", index, "image"),
            partial(str, Sentence("picture '{image}' of beacon '{name}' {fault}", beacon.image, beacon.name, fault)),
        )
        for index, beacon in enumerate(world.beacons)
        if beacon.name in judged and (fault := judged[beacon.name].fault) is not None
    )
    return sorted(problems_at(world.source.written, world.source.file, faults))


def judge_pictures(world: World) -> dict[str, JudgedPicture]:
    """Return how well the picture of each beacon is recognised, by name; empty for a world without cameras."""
    cameras = _cameras(world)
    images = {beacon.name: beacon.image for beacon in world.beacons if beacon.image is not None}
    if not cameras or not images:
        return {}
    files = {image: world.read_asset(image) for image in images.values()}
    digests = {image: hashlib.sha256(data).hexdigest() for image, data in files.items()}
    qualities = _qualities(world, {digest: image for image, digest in digests.items()})
    focal, widths = max(camera.focal for camera in cameras), {beacon.name: beacon.width for beacon in world.beacons}
    first: dict[str, str] = {}
    judged = {}
    for name, image in images.items():
        owner, quality = first.setdefault(digests[image], name), qualities[digests[image]]
        columns, rows = shown_size(files[image])
        side = widths[name] * math.sqrt(rows / columns)
        like = (owner, 1.0) if owner != name else None
        if like is None and quality.like is not None:
            like = first[quality.like[0]], quality.like[1]
        distance = focal * side / quality.least_side
        fault = quality.fault or _confusion(like) or _nearness(distance, widths[name])
        judged[name] = JudgedPicture(least_side=quality.least_side, distance=distance, fault=fault)
    return judged


def judge_images(world: World, images: Sequence[str], *, width: float) -> dict[str, JudgedPicture]:
    """Return how well pictures would be recognised as additional beacons of a world.

    Args:
        world: The world; one without cameras is judged with the default camera.
        images: Paths of the pictures.
        width: Width of the beacons [m].
    """
    hung = {beacon.image: beacon.name for beacon in world.beacons if beacon.image is not None}
    files = {image: world.read_asset(image) for image in sorted({*images, *hung})}
    digests = {image: hashlib.sha256(data).hexdigest() for image, data in files.items()}
    # In a fixed order, so that the note stays valid as long as the pictures are the same.
    qualities = _qualities(world, {digest: image for image, digest in digests.items()})
    owners = {digests[image]: name for image, name in hung.items()}
    likes = {digest: quality.like for digest, quality in qualities.items() if quality.like is not None}
    focal = max(camera.focal for camera in _cameras(world) or [Camera(camera="front")])
    judged = {}
    for image in images:
        own = digests[image]
        # Of two similar pictures, the later one names the earlier.
        pairs = [likes.get(own), *((digest, share) for digest, (other, share) in likes.items() if other == own)]
        like = next(((owners[pair[0]], pair[1]) for pair in pairs if pair is not None and pair[0] in owners), None)
        columns, rows = shown_size(files[image])
        distance = focal * width * math.sqrt(rows / columns) / qualities[own].least_side
        confusion = _confusion((owners[own], 1.0) if own in owners else like)
        fault = qualities[own].fault or confusion or _nearness(distance, width)
        judged[image] = JudgedPicture(least_side=qualities[own].least_side, distance=distance, fault=fault)
    return judged


def _cameras(world: World) -> list[Camera]:
    return [sensor for robot in world.robots for sensor in robot.sensors if isinstance(sensor, Camera)]


def _confusion(like: tuple[str, float] | None) -> str | None:
    """Return the fault of a picture, given the beacon with which it can be confused, and their similarity in [0, 1]."""
    if like is None:
        return None
    other, share = like
    if share == 1.0:
        return Sentence(
            "is the same as that of beacon '{other}', so neither is recognised; give each its own picture", other
        )
    return Sentence(
        "looks like that of beacon '{other}' ({share:.0%} alike), so both may be missed; use a different picture",
        other,
        share,
    )


def _nearness(distance: float, width: float) -> str | None:
    """Return the fault of a picture of a width [m] that is recognised up to a distance [m]; None if that is enough."""
    if distance >= MIN_RECOGNITION_DISTANCE:
        return None
    needed = math.ceil(100.0 * width * MIN_RECOGNITION_DISTANCE / distance) / 100.0
    return Sentence(
        "is recognised only up to {distance:.2f} m by the cameras here; make it {needed:.2f} m wide, or"
        " give a camera more pixels or a narrower view",
        distance,
        needed,
    )


@dataclass(frozen=True, slots=True)
class _Quality:
    """How well a picture can be recognised among others; the fields of `PictureQuality`."""

    least_side: float
    fault: str | None
    like: tuple[str, float] | None


def _qualities(world: World, images: Mapping[str, str]) -> Mapping[str, _Quality]:
    """Return how well each picture is recognised, by digest; cached for some sets, and noted for later processes."""
    cached = _cached(tuple(images))
    if not cached:
        cached.update(_known(images) or _judged(world, images))
    return cached


@lru_cache(maxsize=CACHE_SIZE)
def _cached(digests: tuple[str, ...]) -> dict[str, _Quality]:
    """Return the cache entry of a set of pictures: a dictionary, empty at first."""
    return {}


def _judged(world: World, images: Mapping[str, str]) -> Mapping[str, _Quality]:
    """Judge pictures, and note the result."""
    # Most worlds have cameras and no new pictures, and need not load the code that decodes and judges them.
    from mjsim.algorithms.beacon_vision.picture_quality import picture_qualities

    found = picture_qualities({digest: world.read_picture(image) for digest, image in images.items()})
    rows = {digest: astuple(quality) for digest, quality in found.items()}
    note(json.dumps(rows).encode(), *_about(images))
    return _from_rows(rows)


def _known(images: Mapping[str, str]) -> Mapping[str, _Quality]:
    """Return the notes about a set of pictures; empty if they are missing or invalid."""
    data = noted(*_about(images))
    try:
        qualities = _from_rows(json.loads(data)) if data is not None else {}
    except (ValueError, TypeError, LookupError, AttributeError):
        return {}
    return qualities if qualities.keys() == images.keys() else {}


def _from_rows(rows: Mapping[str, Sequence[Any]]) -> Mapping[str, _Quality]:
    qualities = {}
    for digest, (least_side, fault, like) in rows.items():
        qualities[digest] = _Quality(float(least_side), fault, None if like is None else (str(like[0]), float(like[1])))
    return qualities


def _about(images: Mapping[str, str]) -> Sequence[str]:
    """Return what a judgement depends on: the pictures in their order, and the code that judges."""
    return "pictures", *_code(), *images


@cache
def _code() -> Sequence[str]:
    """Return the version of OpenCV, and the SHA-256 of each algorithm."""
    files = sorted(Path(str(resources.files("mjsim.algorithms"))).rglob("*.py"))
    version = metadata.version("opencv-python-headless")
    return version, *(hashlib.sha256(file.read_bytes()).hexdigest() for file in files)
