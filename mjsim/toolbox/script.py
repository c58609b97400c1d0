"""Runs a script in Octave and writes its figures."""

import io
import re
import subprocess
import tempfile
import warnings
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mjsim.errors import UsageError
from mjsim.interface import quoted
from mjsim.modules import TOOLBOX, find_octave
from mjsim.output import free_paths, write_set
from mjsim.toolbox.calls import read_calls, write_recorders
from mjsim.toolbox.missing import explained
from mjsim.toolbox.translation import Translation, in_files_of, translate

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mjsim.toolbox.draw import ScriptFigures
    from mjsim.toolbox.panes import ArmMotion

HERE = Path(__file__).parent
FLAGS = ("--norc", "--no-history", "--no-line-editing", "--no-window-system", "--quiet", "--no-gui")
SILENCED_WARNINGS = (
    "possible-matlab-short-circuit-operator",
    "function-name-clash",
    "shadowed-function",
    "language-extension",
)
FILM_RATE, MAX_FRAMES = 25.0, 100
"""Frames of a film in a second, and the maximum number of different ones."""
FRAMES_PER_POSTURE = 2
"""Frames for which each posture is shown."""
CJK = ("Noto Sans CJK JP", "Noto Sans CJK SC", "Noto Sans CJK TC", "Noto Sans CJK KR", "WenQuanYi Zen Hei",
       "WenQuanYi Micro Hei", "IPAexGothic", "IPAGothic", "TakaoGothic", "Droid Sans Fallback", "Arial Unicode MS",
       "Unifont")  # fmt: skip
"""Installed fonts for characters that the usual one lacks."""
GLYPH = re.compile(r"Glyph (\d+) ")
MARK = "mjsim-error: "
"""Prefix of the error of a script on standard error."""
NOISE = re.compile(r"DISPLAY|GUI features|^warning: called from|^ {4}\S+ at line \d+|ignoring const exec|^\s*$")
"""Lines on standard error that are not about the script."""
MAX_WARNINGS = 20
OTHER_FORMATS = ("eps", "svg", "jpg", "jpeg", "tif", "tiff")
"""Formats that a script may request, beside PNG and PDF."""
RASTERS = ("png", "jpg", "jpeg", "tif", "tiff")
"""Formats of pixels."""
DPI, MAX_DPI = 110, 600
"""Resolution of PNG files, and the maximum that a script may ask for [dots per inch]."""


@dataclass(frozen=True, slots=True)
class ScriptRun:
    """Result of a script."""

    files: tuple[Path, ...]
    """Files that were written."""
    notes: tuple[str, ...]
    """Warnings of the script, and what could not be drawn, one line each."""
    driven: Path | None
    """File of the arm for which the script opened sliders."""
    error: str | None
    """Error that ended the script early; figures drawn until then are written."""


def run_script(script: Path, folder: Path, *, overwrite: bool = False) -> ScriptRun:
    """Run a script in Octave, with the functions for arms, and write its figures as PNG and PDF, arms as films too.

    What the script prints goes to standard output.

    Args:
        script: The script; it runs in its own folder.
        folder: Output folder; created if necessary.
        overwrite: Whether files may be replaced.

    Raises:
        UsageError: The script does not exist, Octave is not installed, or a file exists.
    """
    if not script.is_file() or script.suffix != ".m":
        raise UsageError(f"no script '{script}'; name a file that ends in .m")
    free_paths(folder, ["figure-1.png"], overwrite=overwrite)
    with tempfile.TemporaryDirectory(prefix="mjsim-octave-") as place:
        write_recorders(Path(place))
        record = Path(place) / "calls.mat"
        error, warnings = _run(script.resolve(), Path(place), record)
        calls = list(read_calls(record)) if record.is_file() else []
    files, notes, driven = drawn_files(calls)
    write_set(folder, files, of=f"script {script.name}", overwrite=overwrite)
    return ScriptRun(
        tuple(folder / name for name in files), (*warnings, *notes), None if driven is None else folder / driven, error
    )


def _run(script: Path, recorders: Path, record: Path) -> tuple[str | None, list[str]]:
    """Run Octave; return the error that ended the script, as one line, and its warnings."""
    made = translate(script, recorders / "own")
    words = [find_octave(), *FLAGS, "--eval", _code(script, made, recorders, record)]
    done = subprocess.run(words, cwd=script.parent, stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, check=False)
    lines = [line for line in done.stderr.decode(errors="replace").splitlines() if not NOISE.search(line)]
    marked = next((line.removeprefix(MARK) for line in lines if line.startswith(MARK)), None)
    if marked is None and done.returncode:
        ended = f"ended with exit code {done.returncode}"
        marked = next((line for line in lines if line.startswith(("error:", "parse error"))), ended)
    others = Counter(line for line in lines if not line.startswith((MARK, "error:", "parse error")))
    told = [line + (f" ({count} times)" if count > 1 else "") for line, count in others.most_common(MAX_WARNINGS)]
    if marked is None:
        return None, told
    marked = in_files_of(script, recorders / "own", marked.removeprefix("error: "))
    if any(marked.startswith((f"'{name}' undefined", f"Invalid call to {name}.")) for name in made.parameters):
        return f"{script.name} is a function of {', '.join(made.parameters)}; run a script that calls it", told
    return f"{script.name}: {explained(marked)}", told


def _code(script: Path, made: Translation, recorders: Path, record: Path) -> str:
    """Return the code that Octave runs: the script in the base workspace, as at the prompt."""
    quiet = "".join(f"warning('off','Octave:{name}');" for name in SILENCED_WARNINGS)
    old = [TOOLBOX / "old"] if made.is_old else []
    folders = (recorders / "own", recorders, HERE / "recorder", *old, TOOLBOX, script.parent)
    paths = "".join(f"addpath({quoted(str(folder))});" for folder in folders[::-1])
    called = f"feval({quoted(made.run.stem)})" if made.is_function else f"source({quoted(str(made.run))})"
    told = f"fprintf(stderr,'{MARK}%s\\n',mjsim_told(mjsim_caught,{quoted(str(script))},{quoted(str(recorders))}));"
    return f"{quiet}{paths}mjsim_start({quoted(str(record))});try,{called};catch mjsim_caught,{told}exit(1);end"


def drawn_files(calls: Sequence[Any]) -> tuple[dict[str, bytes], list[str], str | None]:
    """Return the files of recorded calls by name, what could not be drawn, and the name of the driven arm's file."""
    from matplotlib import rc_context

    from mjsim.toolbox.draw import ScriptFigures
    from mjsim.toolbox.drawing_functions import FUNCTIONS
    from mjsim.toolbox.film_functions import film_files
    from mjsim.video import write_film

    drawn, notes = ScriptFigures(), []
    files: dict[str, bytes] = {}
    with rc_context({"font.family": ["DejaVu Sans", *_installed(CJK)], "axes.unicode_minus": False}):
        drawn.draw(calls, FUNCTIONS)
        files |= film_files(drawn.films, write_film, rate=FILM_RATE)
        for number, figure in sorted(drawn.figures.items()):
            saved = [Path(name) for shown, name in drawn.files if shown == number]
            others = {kind for name in saved if (kind := name.suffix[1:].lower()) in OTHER_FORMATS}
            pictures, missing = _pictures(figure, ["png", "pdf", *sorted(others)])
            for name in dict.fromkeys([f"figure-{number}", *(name.stem for name in saved)]):
                files |= {f"{name}.{kind}": pictures[kind] for kind in ("png", "pdf")}
            files |= {f"{name.stem}{name.suffix}": pictures[name.suffix[1:].lower()] for name in saved
                      if name.suffix[1:].lower() in others}  # fmt: skip
            for file in (each for each in saved if each.stem in drawn.resolutions):
                raster = [kind for kind in ("png", file.suffix[1:].lower()) if kind in RASTERS]
                sharp, _ = _pictures(figure, raster, dpi=drawn.resolutions[file.stem])
                files |= {f"{file.stem}.{kind}": content for kind, content in sharp.items()}
            if missing:
                notes.append(f"figure {number}: no installed font has '{missing}'; install fonts-noto-cjk")
            films = {m.arm.name: m for m in drawn.motions.get(number, []) if len(m.postures()) > 2}
            files |= {f"figure-{number}{_tail(k)}.mp4": _film(m) for k, m in enumerate(films.values())}
    notes += [f"not drawn as written: {each}" for each in sorted(drawn.skipped)]
    driven = None
    if drawn.driven is not None:
        driven = f"{re.sub('[^A-Za-z0-9_-]+', '_', str(drawn.driven['name'])) or 'arm'}.yaml"
        files[driven] = _arm_file(drawn).encode()
        moved = [part for part in ("base", "tool") if not np.allclose(drawn.driven[part], np.eye(4))]
        if moved:
            notes.append(f"the arm of the sliders has no {' and no '.join(moved)}: a table of joints has none")
    return files, notes, driven


def _tail(number: int) -> str:
    return f"-{number + 1}" if number else ""


def _installed(names: Sequence[str]) -> list[str]:
    from matplotlib.font_manager import fontManager

    there = {font.name for font in fontManager.ttflist}
    return [name for name in names if name in there]


def _pictures(figure: "Figure", kinds: Sequence[str], *, dpi: int = DPI) -> tuple[dict[str, bytes], str]:
    """Return a figure in some formats, and the characters that no font has."""
    found = {}
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        if figure.get_layout_engine() is not None:
            # The first layout changes ticks, whose labels need another one.
            figure.draw_without_rendering()
        for kind in kinds:
            place = io.BytesIO()
            figure.savefig(place, format=kind, dpi=min(dpi, MAX_DPI))
            # All files have the layout of the first.
            figure.set_layout_engine("none")
            found[kind] = place.getvalue()
    codes = [int(match[1]) for each in told if (match := GLYPH.search(str(each.message)))]
    return found, "".join(dict.fromkeys(map(chr, codes)))


def _film(motion: "ArmMotion") -> bytes:
    """Return the film of an arm's motion."""
    from mjsim.video import write_film

    with tempfile.TemporaryDirectory(prefix="mjsim-film-") as place:
        file = Path(place) / "film.mp4"
        write_film(_frames(motion), file)
        return file.read_bytes()


def _frames(motion: "ArmMotion") -> Iterator[np.ndarray[Any, np.dtype[np.uint8]]]:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    q = motion.postures()
    rows = np.unique(np.linspace(0, len(q) - 1, min(len(q), MAX_FRAMES)).round().astype(int))
    figure = Figure(figsize=(4.8, 4.4), dpi=100)
    canvas: Any = FigureCanvasAgg(figure)
    axes: Any = figure.add_axes((0.0, 0.0, 1.0, 0.95), projection="3d", title=motion.arm.name)
    bounds, way = motion.arm.extent(q[rows]), motion.arm.fkine(q)[:, :3, 3]
    empty: Any = None
    for row in rows:
        motion.arm.draw(axes, q[row], bounds=bounds)
        if motion.pane is not None:
            # The picture has the limits and the view that the script wants.
            seen = motion.pane.axes
            axes.set(xlim=seen.get_xlim(), ylim=seen.get_ylim(), zlim=seen.get_zlim())
            axes.view_init(elev=seen.elev, azim=seen.azim)
        axes.plot(*way[: row + 1].T, color="#0072bd", lw=1.2)
        moving = sorted([*axes.lines, *axes.texts], key=lambda artist: float(artist.get_zorder()))
        if empty is None:
            # Panes, ticks and labels stay the same, and take most of the time.
            for artist in moving:
                artist.set_visible(False)
            canvas.draw()
            empty = canvas.copy_from_bbox(figure.bbox)
            for artist in moving:
                artist.set_visible(True)
        canvas.restore_region(empty)
        for artist in moving:
            axes.draw_artist(artist)
            artist.remove()
        picture = np.asarray(canvas.buffer_rgba())[:, :, :3].copy()
        for _ in range(FRAMES_PER_POSTURE):
            yield picture


def _arm_file(drawn: "ScriptFigures") -> str:
    """Return the table of the driven arm as a file that `mjsim arm` reads."""
    import json

    from mjsim.toolbox.script_arms import arm_rows, start_of

    assert drawn.driven is not None
    rows, convention = arm_rows(drawn.driven)
    lines = "".join(f"    - {json.dumps(row)}\n" for row in rows)
    start = start_of(rows, drawn.start)
    begins = f"start_deg: {json.dumps(start)}\n" if start is not None else ""
    return f"# From a script of MATLAB.\n{begins}dh:\n  convention: {convention}\n  unit: m\n  rows:\n{lines}"
