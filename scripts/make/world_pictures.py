"""Write docs/worlds.md and docs/images/worlds: shipped worlds as plans, from outside and through a robot's eyes.

python scripts/make/world_pictures.py [WORLD]...   (pictures of all worlds unless some are named)
"""

import sys
import textwrap
from collections.abc import Mapping
from pathlib import Path

import cv2
from PIL import Image

from mjsim.interface import Picture
from mjsim.video import draw_world, take_picture
from mjsim.video.paper import DPI
from mjsim.world import Camera, World, load_checked

FOOT = """
## The control laboratory

The worlds of `worlds/lab` belong to [the lessons](tutorials/control-lessons.md), which show how to use them.
"""
ROOT = Path(__file__).resolve().parents[2]
WORLDS, PAGE, PICTURES = ROOT / "worlds", ROOT / "docs" / "worlds.md", ROOT / "docs" / "images" / "worlds"
ROOMS = ("empty", "gallery", "museum", "cloister", "corridor")
MORE = (
    "office",
    "warehouse",
    "maze",
    "ramps",
    "clutter",
    "avoidance",
    "barn",
    "dark",
    "arena",
    "cooperative",
    "sensors",
    "balancing",
    "pushed",
    "arm",
    "manipulator",
    "foyer",
)
ORDER = (*ROOMS, *MORE)
FOLDERS = {
    "mechanisms": ("Mechanisms", "run {}"),
    "people": ("People at workplaces", "ergonomics {} -o out/{}"),
}
"""Folders of worlds that need no robot: their title on the page, and their use."""
OUTSIDE = {"corridor": "scout/chase"}
"""Views from outside other than the overview."""
HEAD = """# Worlds

These worlds come with mjsim. `mjsim worlds` lists them with their files. Wherever a command takes a WORLD, the name is
enough, even if there is a folder of that name. `mjsim worlds --copy office` makes a copy for you to edit; `mjsim check`
reports errors in it, and `mjsim show WORLD -o plan.png` draws a plan for printing. All of them run unchanged:

```sh
.venv/bin/mjsim run gallery --seconds 30 --video gallery.mp4
```

"""


def about(name: str) -> str:
    """Return the comment at the top of a world, wrapped."""
    lines = (WORLDS / f"{name}.yaml").read_text(encoding="utf-8").splitlines()
    said = []
    for line in lines:
        if not line.startswith("#"):
            break
        if "yaml-language-server" not in line:
            said.append(line.removeprefix("#").strip())
    return textwrap.fill(" ".join(said), 120, break_long_words=False, break_on_hyphens=False)


def camera_of(world: World) -> str:
    """Return the first onboard camera of a world, as ROBOT/CAMERA."""
    found = ((robot.name, item) for robot in world.robots for item in robot.sensors)
    return next(f"{robot}/{item.camera}" for robot, item in found if isinstance(item, Camera))


def page(worlds: Mapping[str, World]) -> str:
    """Return the page of worlds by their names."""
    text = HEAD + "| world | robots | beacons | estimator | navigator |\n|---|---|---|---|---|\n"
    for name, world in worlds.items():
        modules = next(iter(world.run.drivers.values()))
        kinds = [use.use.rpartition(":")[2] if use else "" for use in (modules.estimator, modules.navigator)]
        text += f"| [{name}](#{name}) | {len(world.robots)} | {len(world.beacons)} | {' | '.join(kinds)} |\n"
    for name, world in worlds.items():
        text += f"\n## {name}\n\n{about(name)}\n\n```sh\n.venv/bin/mjsim run worlds/{name}.yaml\n```\n\n"
        text += f"![The plan of {name}](images/worlds/{name}-plan.png)\n\n"
        text += f"![{name} from outside](images/worlds/{name}.jpg)\n\n"
        text += f"![What {camera_of(world)} sees at the start](images/worlds/{name}-onboard.jpg)\n"
    return text + "".join(folder_section(folder, *said) for folder, said in FOLDERS.items()) + FOOT


def folder_section(folder: str, title: str, command: str) -> str:
    """Return the section of a folder's worlds."""
    text = f"\n## {title}\n\nThe worlds of `worlds/{folder}`; `mjsim` finds them by their names.\n"
    for name in (path.stem for path in in_folder(folder)):
        shown = command.format(name, name)
        text += f"\n### {name}\n\n{about(f'{folder}/{name}')}\n\n```sh\n.venv/bin/mjsim {shown}\n```\n\n"
        text += f"![{name} from outside](images/worlds/{name}.jpg)\n"
    return text


def in_folder(folder: str) -> list[Path]:
    """Return the files of the worlds of a folder."""
    return sorted((WORLDS / folder).glob("*.yaml"))


def scaled(picture: Picture, width: int) -> Picture:
    """Return a picture reduced to a width [px]; unchanged if it is small enough."""
    share = width / picture.shape[1]
    return picture if share >= 1 else cv2.resize(picture, None, fx=share, fy=share, interpolation=cv2.INTER_AREA)


def without_sky(picture: Picture) -> Picture:
    """Return a picture without most of the empty rows above and below the world."""
    rows = (picture != picture[0, 0]).any(axis=-1).any(axis=1).nonzero()[0]
    return picture[max(int(rows[0]) - 20, 0) : int(rows[-1]) + 21]


def draw(path: Path) -> None:
    """Write the pictures of a world: of one of a folder from outside alone."""
    name, world = path.stem, load_checked(path)
    write(f"{name}.jpg", scaled(without_sky(take_picture(world, OUTSIDE.get(name, "overview"))), 960))
    if path.parent == WORLDS:
        draw_room(name, world)
    print(name)


def draw_room(name: str, world: World) -> None:
    """Write the plan of a world and what a robot's camera sees."""
    # Few colours make a small file; the sheet keeps its size, so that it can be printed.
    Image.fromarray(draw_world(world)).quantize(128, dither=Image.Dither.NONE).save(
        PICTURES / f"{name}-plan.png", optimize=True, dpi=(DPI, DPI)
    )
    write(f"{name}-onboard.jpg", scaled(take_picture(world, camera_of(world)), 480))


def write(name: str, picture: Picture) -> None:
    """Write a picture as JPEG."""
    encoded = cv2.imencode(".jpg", cv2.cvtColor(picture, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, 76])[1]
    (PICTURES / name).write_bytes(encoded.tobytes())


def main() -> None:
    """Write the page and the pictures."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    paths = [WORLDS / f"{name}.yaml" for name in ORDER] + [path for folder in FOLDERS for path in in_folder(folder)]
    for path in paths:
        if len(sys.argv) == 1 or path.stem in sys.argv[1:]:
            draw(path)
    PAGE.write_text(page({name: load_checked(WORLDS / f"{name}.yaml") for name in ORDER}), encoding="utf-8")


if __name__ == "__main__":
    main()
