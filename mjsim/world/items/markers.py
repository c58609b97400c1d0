"""The dictionaries of square markers that OpenCV knows: how many markers each has, and of how many modules."""

from mjsim.errors import did_you_mean

DICTIONARIES: dict[str, tuple[int, int]] = {
    **{f"{side}x{side}_{count}": (side, count) for side in (4, 5, 6, 7) for count in (50, 100, 250, 1000)},
    "original": (5, 1024),
    "mip_36h12": (6, 250),
    "apriltag_16h5": (4, 30),
    "apriltag_25h9": (5, 35),
    "apriltag_36h10": (6, 2320),
    "apriltag_36h11": (6, 587),
}
"""By name: modules across without the black border, and markers from 0."""


QUIET = 1
"""Width of the white border around the black square, in modules."""


def modules_across(dictionary: str) -> int:
    """Return how many modules the black square of a marker is wide, its border of one module included."""
    return DICTIONARIES[dictionary][0] + 2


def printed_share(dictionary: str) -> float:
    """Return how wide a marker is with its white border, as a multiple of the black square."""
    return 1.0 + 2 * QUIET / modules_across(dictionary)


def check_marker(dictionary: str, number: int) -> tuple[str, str] | None:
    """Return what is wrong with a marker and under which key; None when there is one."""
    if dictionary not in DICTIONARIES:
        return f"no dictionary '{dictionary}'{did_you_mean(dictionary, DICTIONARIES)}", "dictionary"
    _, count = DICTIONARIES[dictionary]
    if number >= count:
        return f"id is {number}; the dictionary {dictionary} has ids from 0 to {count - 1}", "id"
    return None
