#!/usr/bin/env python3
"""Make the pictures and the film of docs/images whose scripts, or the worlds that these name, have changed since.

scripts/make/pictures.py [--list | --keep] [SCRIPT ...]

--list prints what is stale and makes nothing; --keep marks the pictures of a changed script as up to date.
"""

import argparse
import ast
import hashlib
import json
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SOURCES = ROOT / "docs" / "images" / "sources.json"
"""Script -> digest of what its pictures were made from."""
ELSEWHERE = {"architecture_picture.py", "classic_page.py", "robot_page.py", "tutorials.py"}
"""Scripts of generated pages, which tests compare with these."""


class Undocumented(ast.NodeTransformer):
    """Drops text outside of expressions."""

    def visit_Expr(self, node: ast.Expr) -> ast.Expr | None:
        """Return an expression that is a statement, or None for a text."""
        return None if isinstance(node.value, ast.Constant) else node


def makers() -> list[Path]:
    """Return the scripts that make pictures."""
    found = (path for path in Path(__file__).parent.glob("*.py") if path != Path(__file__))
    return sorted(path for path in found if '"images"' in path.read_text() and path.name not in ELSEWHERE)


def digest(script: Path) -> str:
    """Return what identifies the code of a script, without docstrings, and the shipped worlds that it names."""
    text = ast.unparse(Undocumented().visit(ast.parse(script.read_text(encoding="utf-8"))))
    worlds = sorted((ROOT / "worlds").rglob("*.yaml"))
    named = [path.read_bytes() for path in worlds if f"'{path.stem}'" in text or path.name in text]
    return hashlib.sha256(b"\0".join([text.encode(), *named])).hexdigest()


def stale() -> list[Path]:
    """Return the scripts whose pictures are older than their sources."""
    kept = json.loads(SOURCES.read_text()) if SOURCES.exists() else {}
    return [script for script in makers() if kept.get(script.name) != digest(script)]


def keep(script: Path) -> None:
    """Record that the pictures of a script match its current sources."""
    kept = json.loads(SOURCES.read_text()) if SOURCES.exists() else {}
    kept[script.name] = digest(script)
    SOURCES.write_text(json.dumps(kept, indent=1, sort_keys=True) + "\n")


def main() -> None:
    """Make what is stale."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scripts", nargs="*")
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--keep", action="store_true")
    asked = parser.parse_args()
    for script in stale():
        if asked.scripts and script.name not in asked.scripts:
            continue
        print(script.name, flush=True)
        if asked.list:
            continue
        if not asked.keep:
            subprocess.run([sys.executable, script], cwd=ROOT, check=True)
        keep(script)


if __name__ == "__main__":
    main()
