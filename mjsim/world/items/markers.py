"""OpenCV's dictionaries of square markers: number of markers, and modules across."""

from mjsim.errors import did_you_mean
from mjsim.sentences import Sentence

DICTIONARIES: dict[str, tuple[int, int]] = {
    **{f"{side}x{side}_{count}": (side, count) for side in (4, 5, 6, 7) for count in (50, 100, 250, 1000)},
    "original": (5, 1024),
    "mip_36h12": (6, 250),
    "apriltag_16h5": (4, 30),
    "apriltag_25h9": (5, 35),
    "apriltag_36h10": (6, 2320),
    "apriltag_36h11": (6, 587),
}
"""By name: modules across without the black border, and number of markers."""


QUIET = 1
"""Width of the white border around the black square, in modules."""


def modules_across(dictionary: str) -> int:
    """Return the width of a marker's black square in modules, including its border of one module."""
    return DICTIONARIES[dictionary][0] + 2


def printed_share(dictionary: str) -> float:
    """Return the width of a marker with its white border, as a multiple of the black square."""
    return 1.0 + 2 * QUIET / modules_across(dictionary)


def check_marker(dictionary: str, number: int) -> tuple[str, str] | None:
    """Return what is wrong with a marker and under which key; None if it is valid."""
    if dictionary not in DICTIONARIES:
        return Sentence(
            "no dictionary '{dictionary}'{meant}", dictionary, did_you_mean(dictionary, DICTIONARIES)
        ), "dictionary"
    _, count = DICTIONARIES[dictionary]
    if number >= count:
        return Sentence(
            "id is {number}; the dictionary {dictionary} has ids from 0 to {count}", number, dictionary, count - 1
        ), "id"
    return None
