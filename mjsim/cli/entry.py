"""Where the command starts, before anything large is imported."""

import signal
import sys
from collections.abc import Sequence


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line and exit.

    0; 2 after a user error, 1 after a failed run, 129, 130 or 143 when interrupted, 141 when nobody reads its output.
    """
    try:
        from mjsim.cli import program
    except KeyboardInterrupt:
        print("mjsim: interrupted", file=sys.stderr)
        sys.exit(128 + signal.SIGINT)  # as in shells
    program.main(arguments)
