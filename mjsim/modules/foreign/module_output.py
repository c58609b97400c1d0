"""Output of module processes, shown with the name of their robot, within limits."""

from mjsim.errors import printable
from mjsim.progress import show

MAX_LINES = 200
"""Maximum number of lines of one module in one run."""
MAX_LINE_LENGTH = 300
"""Maximum length of a line [characters]."""


class ShownOutput:
    """Shows the first lines that a process prints on the terminal."""

    def __init__(self, who: str) -> None:
        """Store the name of the module that prints, such as 'scout/estimator'."""
        self._who = who
        self._rest = b""
        self._last = ""
        self._lines = 0

    def take(self, data: bytes) -> None:
        """Process output."""
        # An incomplete line is kept up to the length that may be shown.
        *lines, rest = (self._rest + data).split(b"\n") if data else (self._rest,)
        self._rest = rest[: 4 * MAX_LINE_LENGTH]
        left = max(0, MAX_LINES + 1 - self._lines)
        for line in (*lines[:left], *lines[left:][-1:]):
            self._show(line)

    def last(self) -> str:
        """Return the last non-empty line, for messages."""
        self.close()
        return self._last

    def close(self) -> None:
        """Show the last line if it is incomplete."""
        rest, self._rest = self._rest, b""
        if rest:
            self._show(rest)

    def _show(self, line: bytes) -> None:
        text = printable(line[: 4 * MAX_LINE_LENGTH].decode(errors="replace").expandtabs().rstrip())[:MAX_LINE_LENGTH]
        self._last = text or self._last
        self._lines += 1
        if self._lines <= MAX_LINES:
            show(f"{self._who}: {text}")
        elif self._lines == MAX_LINES + 1:
            show(f"{self._who}: (what it prints after {MAX_LINES} lines is not shown)")
