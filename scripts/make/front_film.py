"""Make film and table of the front page, docs/images/run.webp and run.txt: 24 s of the gallery, five times as fast.

Usage: python scripts/make/front_film.py
"""

import itertools
import tempfile
from pathlib import Path

import av
from PIL import Image

import mjsim
from mjsim.report import key_table, statistics_file
from mjsim.video import make_video

FILM = Path(__file__).parents[2] / "docs" / "images" / "run.webp"
TABLE = FILM.with_suffix(".txt")
SECONDS, EVERY, WIDTH = 24.0, 10, 640
"""Length of the run [s]; each tenth frame of 25 a second is kept and shown for 80 ms; width of the film [px]."""


def main() -> None:
    """Run the gallery, write its table, draw the film, and shrink it."""
    with tempfile.TemporaryDirectory() as folder:
        recording = mjsim.run("gallery", seconds=SECONDS, record=f"{folder}/run.mcap")
        lines = key_table(statistics_file(recording))
        kept = [line for line in lines if not line.startswith("real-time")]  # that is of this machine
        TABLE.write_text("\n".join(kept) + "\n", encoding="utf-8")
        make_video(recording, Path(folder, "run.mp4"))
        with av.open(f"{folder}/run.mp4") as film:
            frames = itertools.islice(film.decode(video=0), 0, None, EVERY)
            images = [frame.to_image() for frame in frames]
    small = [image.resize((WIDTH, image.height * WIDTH // image.width), Image.Resampling.LANCZOS) for image in images]
    small[0].save(FILM, save_all=True, append_images=small[1:], duration=80, loop=0, quality=45, method=4)


if __name__ == "__main__":
    main()
