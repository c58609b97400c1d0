"""Films and animated pictures that a script makes itself, from the frames that it takes of its figures."""

import io
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjsim.toolbox.arm_functions import drawn_now
from mjsim.toolbox.calls import FigureCall
from mjsim.toolbox.draw import Drawing, ScriptFigures

Picture = NDArray[np.uint8]
MAX_FRAMES = 300
"""Maximum number of frames that are drawn of all figures of a script."""
SECONDS_PER_FRAME = 0.1
"""Time of a frame of an animated picture [s]."""


def _frame(drawn: ScriptFigures, call: FigureCall) -> list[Any]:
    """Draw a figure as it is now."""
    if len(drawn.frames) >= MAX_FRAMES:
        drawn.skipped.add(f"getframe: a film ends after {MAX_FRAMES} frames")
    else:
        drawn.frames[call.number] = drawn_now(drawn, call.figure)
    return []


def _video(drawn: ScriptFigures, call: FigureCall) -> None:
    """Add frames to a film."""
    name, rate, ids = call.arguments
    film = drawn.films.setdefault(f"{Path(name).stem}.mp4", (float(np.ravel(rate)[0]), []))[1]
    film += [drawn.frames[int(each)] for each in np.ravel(ids).tolist() if int(each) in drawn.frames]


def _picture(drawn: ScriptFigures, call: FigureCall) -> None:
    """Keep a frame as a picture of its own, or add it to an animated one."""
    frame = drawn.frames.get(int(np.ravel(call.arguments[0])[0]))
    if frame is not None:
        drawn.films.setdefault(Path(call.arguments[1]).name, (1.0 / SECONDS_PER_FRAME, []))[1].append(frame)


def film_files(
    films: Mapping[str, tuple[float, Sequence[Picture]]],
    write: Callable[[Iterator[Picture], Path], None],
    *,
    rate: float,
) -> dict[str, bytes]:
    """Return the files of films and pictures by name.

    Args:
        films: Frames in a second, and frames, by the name of the file.
        write: Encodes frames into a file.
        rate: Frames in a second of what it encodes.
    """
    made = {}
    for name, (wanted, frames) in films.items():
        size = frames[0].shape if frames else ()
        same = [frame for frame in frames if frame.shape == size]
        if not same:
            continue
        if name.endswith(".mp4"):
            with tempfile.TemporaryDirectory(prefix="mjsim-film-") as place:
                write(_at_rate(same, wanted, rate), Path(place) / name)
                made[name] = (Path(place) / name).read_bytes()
        else:
            made[name] = _image_file(name, same, wanted)
    return made


def _at_rate(frames: Sequence[Picture], wanted: float, rate: float) -> Iterator[Picture]:
    """Yield each frame as often as its rate requires, with an even number of rows and columns."""
    for k in range(max(1, round(len(frames) * rate / wanted))):
        frame = frames[min(int(k * wanted / rate), len(frames) - 1)]
        yield np.ascontiguousarray(frame[: len(frame) // 2 * 2, : frame.shape[1] // 2 * 2])


def _image_file(name: str, frames: Sequence[Picture], rate: float) -> bytes:
    from PIL import Image

    first, *others = [Image.fromarray(frame) for frame in (frames if name.endswith(".gif") else frames[-1:])]
    place = io.BytesIO()
    kind = {"jpg": "jpeg", "tif": "tiff"}.get(name.rpartition(".")[2].lower(), name.rpartition(".")[2])
    more: dict[str, Any] = {"save_all": True, "append_images": others, "duration": 1000.0 / rate, "loop": 0}
    first.save(place, format=kind, **(more if others else {}))
    return place.getvalue()


FILM_FUNCTIONS: Mapping[str, Drawing] = {"getframe": _frame, "writeVideo": _video, "imwrite": _picture}
"""Functions that take and keep frames, by the names of their calls."""
