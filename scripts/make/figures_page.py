#!/usr/bin/env python3
"""Make docs/figures.md anew: each table by the command above it, with the date and the commit of today.

With words, only tables whose command holds one of them: all take hours on two cores.
"""

import argparse
import os
import re
import subprocess
import sys
from datetime import UTC, datetime
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "figures.md"
MADE = re.compile(
    r"^`(?P<command>(?:scripts/|mjsim )[^`]+)`, (?P<when>\d{4}-\d\d-\d\d, [0-9a-f]{8}):\n\n(?P<table>(?:\|.*\n)+)", re.M
)


def output_of(command: str) -> str:
    """Return the rows of the table that a command prints.

    Raises:
        SystemExit: It failed, or printed none.
    """
    bin_folder = Path(sys.executable).parent
    path = os.pathsep.join([str(bin_folder), os.environ["PATH"]])
    words = ["bash", "-c", command]
    printed = subprocess.run(words, cwd=ROOT, env=os.environ | {"PATH": path}, stdout=subprocess.PIPE, text=True)
    rows = "".join(f"{line}\n" for line in printed.stdout.splitlines() if line.startswith("|"))
    if printed.returncode or not rows:
        raise SystemExit(f"no table, exit code {printed.returncode}: {command}")
    return rows


def main() -> None:
    """Run the commands in the order of the page, and write it after each: an interrupted run keeps its results."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("words", nargs="*")
    parser.add_argument("--list", action="store_true", help="print the commands, run none")
    asked = parser.parse_args()
    commit = subprocess.check_output(["git", "rev-parse", "--short=8", "HEAD"], cwd=ROOT, text=True).strip()
    for old in MADE.finditer(PAGE.read_text(encoding="utf-8")):
        command = old["command"]
        if asked.words and not any(word in command for word in asked.words):
            continue
        print(command, flush=True)
        if not asked.list:
            new = f"`{command}`, {datetime.now(UTC):%Y-%m-%d}, {commit}:\n\n{output_of(command)}"
            PAGE.write_text(PAGE.read_text(encoding="utf-8").replace(old[0], new), encoding="utf-8")


if __name__ == "__main__":
    main()
