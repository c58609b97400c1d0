"""Diagnosis of this machine: OpenGL and its speed, extras, GNU Octave, and how to install what is missing."""

import os
import re
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

import cv2
import mujoco

from mjsim.compile import compile_world
from mjsim.errors import OpenGLError, UsageError, how_to_install
from mjsim.guarded import guarded
from mjsim.interface import Picture
from mjsim.modules import octave_found
from mjsim.output import require_free, write_file
from mjsim.sim import BACKENDS, Renderer, choose_backend, make_context
from mjsim.sweep import usable_cores
from mjsim.world import parse_world

WIDTH, HEIGHT = 640, 480
BACKEND_TIMEOUT = 60.0
"""Time limit for trying a backend [s]."""
LIBRARIES = ("mujoco", "numpy", "opencv-python-headless", "dm-control", "foxglove-sdk", "av")
EXTRAS = {
    "dask": "sweeps on a Dask cluster",
    "docs": "the documentation site",
    "dxf": "import of DXF drawings",
    "evo": "comparison of mjsim's errors with those of evo",
    "graph": "the estimator GraphSlam",
    "gymnasium": "Gymnasium environments",
    "pandas": "recordings as pandas tables",
    "parquet": "sweep tables as Parquet",
    "peers": "other simulators for mjsim bench --peers",
    "planning": "the navigator PathTracking",
    "ros": "ROS 1 and ROS 2 bags",
    "ros2": "a running world as a ROS 2 robot",
    "usd": "export to USD",
}
"""What each extra of the package is for."""
ROOM = """
mjsim: 1
name: doctor
walls:
  - points: [[0, 0], [6, 0], [6, 4], [0, 4]]
    closed: true
obstacles:
  - {box: [0.8, 0.5, 1.1], at: [4.5, 2.8], heading_deg: 30, color: "#3465a4"}
  - {box: [0.4, 0.4, 0.4], at: [3.0, 1.0], color: "#cc3333"}
  - {cylinder: [0.2, 1.0], at: [4.6, 1.2], color: "#e0b020"}
"""
PROBE = """
import sys
from mjsim.errors import OpenGLError
from mjsim.sim.gl.opengl import try_backend
try:
    print("works:", try_backend(sys.argv[1]))
except OpenGLError as error:
    print("no:", error)
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Diagnosis:
    """What was found on this machine."""

    backend: str | None
    """The OpenGL backend that mjsim uses; None if none works."""
    renderer: str | None
    """Name of the renderer, as OpenGL reports it."""
    pictures_per_second: float | None
    """Speed with a small room, 640 x 480."""
    picture: Path | None
    """File of the test picture."""
    fault: str | None
    """One line that says what to type, if there is no backend."""
    backends: Mapping[str, str]
    """Result of each backend, tried in a separate process."""
    versions: Mapping[str, str]
    """Versions of Python and of the main libraries."""
    extras: Mapping[str, Sequence[str]]
    """Packages that each extra lacks; none if it is installed."""
    octave: str
    """Version and path of GNU Octave, for modules in .m files; or what to type if there is none."""
    cores: int
    """Number of processors that this process may use."""
    limits: str
    """Whether the limits of the process that reads untrusted files hold on this system."""


def diagnose(picture: Path | None, *, overwrite: bool = False) -> Diagnosis:
    """Find out which OpenGL works here and how fast, and whether Octave is installed.

    Args:
        picture: File for a test picture, PNG; None for no picture.
        overwrite: Whether that may replace a file.

    Raises:
        UsageError: The picture exists, or cannot be written.
    """
    if picture is not None:
        require_free(picture, overwrite=overwrite)
    backends = {name: _try_alone(name) for name in BACKENDS}
    versions = {"python": sys.version.split()[0]} | {name: _version(name) for name in LIBRARIES}
    octave, cores, limits, extras = octave_found(), usable_cores(), _limits(), missing_of_extras()
    try:
        backend, renderer = choose_backend(), _renderer()
    except OpenGLError as error:
        return Diagnosis(
            backend=None,
            renderer=None,
            pictures_per_second=None,
            picture=None,
            fault=str(error),
            backends=backends,
            versions=versions,
            extras=extras,
            octave=octave,
            cores=cores,
            limits=limits,
        )
    image, rate = _draw_room()
    if picture is not None:
        data = cv2.imencode(".png", cv2.cvtColor(image, cv2.COLOR_RGB2BGR))[1].tobytes()
        write_file(picture, data, overwrite=overwrite)
    return Diagnosis(
        backend=backend,
        renderer=renderer,
        pictures_per_second=rate,
        picture=picture,
        fault=None,
        backends=backends,
        versions=versions,
        extras=extras,
        octave=octave,
        cores=cores,
        limits=limits,
    )


def report_lines(diagnosis: Diagnosis) -> Sequence[str]:
    """Return a diagnosis as lines of text."""
    lines = [f"backend   {diagnosis.backend or 'none'}"]
    if diagnosis.backend:
        lines += [
            f"renderer  {diagnosis.renderer}",
            f"speed     {diagnosis.pictures_per_second:.0f} pictures per second of a small room, {WIDTH} x {HEIGHT}",
        ]
    if diagnosis.picture:
        lines.append(f"picture   {diagnosis.picture}")
    lines += ["", "backends, each tried in a separate process"]
    lines += [f"  {name:24}{result}" for name, result in diagnosis.backends.items()]
    lines += ["", "versions"]
    lines += [f"  {name:24}{version}" for name, version in diagnosis.versions.items()]
    lines += ["", "extras, each a set of optional packages", *_extra_lines(diagnosis.extras)]
    lines += ["", f"octave    {diagnosis.octave}", f"cores     {diagnosis.cores}", f"limits    {diagnosis.limits}"]
    if diagnosis.fault:
        lines += ["", diagnosis.fault]
    return lines


def missing_of_extras() -> dict[str, list[str]]:
    """Return the packages that each extra of mjsim lacks here, as its metadata lists them."""
    needs = [(re.search(r'extra == "(\w+)"', each), each) for each in metadata.requires("mjsim") or ()]
    packages = [(found[1], re.split(r"[^\w.-]", each, maxsplit=1)[0]) for found, each in needs if found]
    return {
        extra: [name for of, name in packages if of == extra and _version(name) == "not installed"] for extra in EXTRAS
    }


def _extra_lines(extras: Mapping[str, Sequence[str]]) -> list[str]:
    found = {name: f"lacks {', '.join(missing)}" if missing else "installed" for name, missing in extras.items()}
    wide = max(map(len, found.values())) + 2
    lines = [f"  {name:11}{text:{wide}}{EXTRAS[name]}" for name, text in found.items()]
    return [*lines, f"  to add one: {how_to_install('PACKAGE')}"] if any(extras.values()) else lines


def limits_held(missing: Sequence[str]) -> str:
    """Return a line about the limits of the guarded reader, given those that this system lacks."""
    if missing:
        return f"untrusted files are read without limits on {', '.join(missing)}; Linux 5.13 and later have them"
    return "memory, time, other files, network and programs are limited where untrusted files are read"


def _limits() -> str:
    try:
        return limits_held(guarded("mjsim.guarded:missing_limits", about="doctor"))
    except UsageError as error:
        return f"no untrusted file can be read: {error}"


def _try_alone(name: str) -> str:
    """Return the result of trying a backend in a separate process: MuJoCo keeps the first backend it loads."""
    environment = {key: value for key, value in os.environ.items() if key not in ("MUJOCO_GL", "MJSIM_GL")}
    words = [sys.executable, "-c", PROBE, name]
    try:
        done = subprocess.run(
            words, env=environment, capture_output=True, text=True, check=False, timeout=BACKEND_TIMEOUT
        )
    except subprocess.TimeoutExpired:
        return f"no: the process did not end within {BACKEND_TIMEOUT:g} s"
    if done.returncode < 0:
        return f"no: the process died of signal {-done.returncode}"
    return (done.stdout or done.stderr).strip().rpartition("\n")[2]


def _renderer() -> str:
    context = make_context(1, 1)
    context.make_current()
    try:
        return context.renderer()
    finally:
        context.free()


def _version(name: str) -> str:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return "not installed"


def _draw_room() -> tuple[Picture, float]:
    """Return a picture of a small room, and how many such pictures are rendered per second."""
    model = compile_world(parse_world(ROOM, file="doctor.yaml")).compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    camera = mujoco.MjvCamera()
    camera.lookat[:] = (4.0, 2.0, 0.6)
    camera.distance, camera.azimuth, camera.elevation = 3.2, 10.0, -15.0
    with Renderer(model, width=WIDTH, height=HEIGHT) as renderer:
        image = renderer.render(data, camera)
        count, start = 0, time.perf_counter()
        while time.perf_counter() < start + 1.0:
            renderer.render(data, camera, image)
            count += 1
        return image, count / (time.perf_counter() - start)
