"""Make the notebooks of docs/tutorials from their pages, and with --pictures the pictures by running them.

python scripts/make/tutorials.py [--pictures] [PAGE ...]

A page is the one source. Its blocks become cells: Python as it is, `sh` with %%bash, and a block with a caption, which
names a file, with %%writefile. A picture docs/images/tutorials/PAGE-NAME.png is NAME.png, which the page's code writes.
"""

import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FOLDER, PICTURES = ROOT / "docs" / "tutorials", ROOT / "docs" / "images" / "tutorials"
SOURCES = PICTURES / "sources.json"
"""Digest of the code that made the pictures of each page."""
BLOCK = re.compile(r"^```(?:\{code-block\} *)?(\w*)\n(?::caption: (\S+)\n\n?)?(.*?)^```\n", re.MULTILINE | re.DOTALL)


def cells(page: str) -> Iterator[tuple[str, str]]:
    """Yield kind, 'markdown' or 'code', and text of each cell of a page."""
    begin = 0
    for found in BLOCK.finditer(page):
        language, file, code = found.groups()
        head = f"%%writefile {file}\n" if file else {"sh": "%%bash\n", "python": ""}.get(language)
        if head is None:
            continue
        if text := page[begin : found.start()].strip("\n"):
            yield "markdown", text
        yield "code", f"{head}{code}".rstrip("\n")
        begin = found.end()
    if text := page[begin:].strip("\n"):
        yield "markdown", text


def notebook(page: str) -> str:
    """Return the notebook of a page as its file has it."""
    made = []
    for number, (kind, text) in enumerate(cells(page)):
        cell = {"cell_type": kind, "id": f"cell-{number}", "metadata": {}, "source": text.splitlines(keepends=True)}
        made.append(cell | ({"execution_count": None, "outputs": []} if kind == "code" else {}))
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    content = {"cells": made, "metadata": {"kernelspec": kernel}, "nbformat": 4, "nbformat_minor": 5}
    return json.dumps(content, indent=1, ensure_ascii=False) + "\n"


def digest(page: str) -> str:
    """Return what identifies the code of a page."""
    code = [text for kind, text in cells(page) if kind == "code"]
    return hashlib.sha256("\n\n".join(code).encode()).hexdigest()


def put(page: Path, folder: Path) -> list[str]:
    """Write the notebook of a page into a folder; return the settings with which IPython runs it there."""
    folder.joinpath(".ipython").mkdir()
    folder.joinpath(f"{page.stem}.ipynb").write_text(notebook(page.read_text(encoding="utf-8")), encoding="utf-8")
    return ["--no-banner", "--colors=nocolor", f"--ipython-dir={folder / '.ipython'}", f"{page.stem}.ipynb"]


def environment() -> dict[str, str]:
    """Return the environment of a notebook that runs without a browser."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    return {**os.environ, "PATH": path, "MPLBACKEND": "agg"}


def run(page: Path, folder: Path) -> "subprocess.CompletedProcess[str]":
    """Run the notebook of a page in a folder."""
    words = [sys.executable, "-m", "IPython", *put(page, folder)]
    said = {"capture_output": True, "text": True}
    return subprocess.run(words, cwd=folder, env=environment(), timeout=600, check=False, **said)


def pictures(page: Path) -> list[Path]:
    """Return the pictures that a page shows and its own code writes."""
    named = re.findall(r"\]\(\.\./images/tutorials/(\S+?\.png)\)", page.read_text(encoding="utf-8"))
    return [PICTURES / name for name in named]


def make_pictures(page: Path) -> None:
    """Run a page and keep its pictures."""
    with tempfile.TemporaryDirectory() as place:
        done = run(page, Path(place))
        if done.returncode:
            raise SystemExit(f"{page}: {done.stdout}{done.stderr}")
        PICTURES.mkdir(exist_ok=True)
        for path in pictures(page):
            shutil.copy(Path(place) / path.name.removeprefix(f"{page.stem}-"), path)
    known = json.loads(SOURCES.read_text()) if SOURCES.exists() else {}
    known[page.stem] = digest(page.read_text(encoding="utf-8"))
    SOURCES.write_text(json.dumps(known, indent=1, sort_keys=True) + "\n")


if __name__ == "__main__":
    chosen = [word for word in sys.argv[1:] if not word.startswith("-")]
    for page in sorted(FOLDER.glob("*.md")):
        if chosen and page.stem not in chosen:
            continue
        page.with_suffix(".ipynb").write_text(notebook(page.read_text(encoding="utf-8")), encoding="utf-8")
        if "--pictures" in sys.argv:
            make_pictures(page)
        print(page.with_suffix(".ipynb"))
