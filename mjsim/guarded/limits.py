"""Limits of the child process that decodes an untrusted file."""

from dataclasses import dataclass

BASE_MEMORY = 768 << 20
"""Memory for a small file, libraries included [bytes]; with mjsim itself that is below 1 GB."""
MEMORY_PER_BYTE = 64
"""Further memory for each byte of a file, which may be compressed."""
ANSWER_DIVISOR = 3
"""A child hands back at most its memory divided by this at once, as the caller needs that memory again."""
BASE_SECONDS = 14.0
"""Time for a small file [s]; with the start of the child that is below 20 s."""
SECONDS_PER_MEGABYTE = 10.0
"""Further time for each megabyte of a file, about ten times what large drawings, maps and logs need [s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Allowance:
    """What a child may use to decode one file."""

    memory: int = BASE_MEMORY
    """Private memory [bytes]."""
    seconds: float = BASE_SECONDS
    """Time that the caller waits for it, and processor time that it uses, for one call [s]."""
    each: float = 0.0
    """Minimum time allowed for each part of a value that is returned in parts [s]."""
    written: int = 1 << 40
    """Maximum size of a temporary file [bytes]."""

    @property
    def answer(self) -> int:
        """Maximum size of one result [bytes]."""
        return self.memory // ANSWER_DIVISOR

    def __post_init__(self) -> None:
        """Check that they are above 0."""
        if min(self.memory, self.written) <= 0 or not 0.0 < self.seconds < float("inf"):
            raise ValueError(f"limits are {self.memory} bytes and {self.seconds} s; both must be above 0")


def limits_for(size: int) -> Allowance:
    """Return the limits for a file of some size [bytes]."""
    return Allowance(
        memory=BASE_MEMORY + MEMORY_PER_BYTE * size, seconds=BASE_SECONDS + SECONDS_PER_MEGABYTE * size / 1e6
    )
