import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from mjsim.errors import OpenGLError, how_to_install
from mjsim.gl_request import hide_request_from_mujoco, requested_backend
from mjsim.sim import BACKENDS, choose_backend, make_context
from mjsim.sim.gl.opengl import APT_LINE, CHECKOUT
from mjsim.sim.gl.osmesa import has_package, system_osmesa
from tests.children import completed

DRAW_A_RED_WALL = """
from mjsim.errors import OpenGLError
from mjsim.sim.gl.opengl import choose_backend
from mjsim.sim.rendering.renderer import Renderer
import mujoco
try:
    backend = choose_backend()
except OpenGLError as error:
    raise SystemExit(str(error))
model = mujoco.MjModel.from_xml_string('''<mujoco>
    <visual><headlight ambient="1 1 1" diffuse="0 0 0" specular="0 0 0"/></visual>
    <worldbody><geom type="box" size="0.1 5 5" pos="2 0 0" rgba="1 0 0 1"/>
    <camera name="eye" xyaxes="0 -1 0 0 0 1"/></worldbody></mujoco>''')
data = mujoco.MjData(model)
mujoco.mj_forward(model, data)
with Renderer(model, width=16, height=12) as renderer:
    picture = renderer.render(data, "eye")
print(backend, *picture.min((0, 1)), *picture.max((0, 1)), sep=",")
"""
NO_VENDOR = {"__EGL_VENDOR_LIBRARY_FILENAMES": "/nowhere.json"}


def in_a_process(folder: Path | None = None, **environment: str) -> subprocess.CompletedProcess[str]:
    inherited = {name: value for name, value in os.environ.items() if name not in ("MUJOCO_GL", "MJSIM_GL")}
    return completed([sys.executable, "-c", DRAW_A_RED_WALL], check=False, cwd=folder, env=inherited | environment)


def has_system_osmesa() -> bool:
    try:
        system_osmesa()
    except OpenGLError:
        return False
    return True


def test_this_process_has_one_backend_whose_contexts_come_and_go():
    assert choose_backend() in BACKENDS
    first, second = make_context(8, 8), make_context(8, 8)
    first.make_current()
    name = first.renderer()
    second.make_current()
    assert second.renderer() == name
    second.free()
    second.free()
    first.make_current()
    assert first.renderer() == name
    first.free()
    with pytest.raises(OpenGLError, match="was freed"):
        first.make_current()


@pytest.mark.slow
@pytest.mark.parametrize("backend", BACKENDS)
def test_each_backend_that_is_here_draws_a_red_wall_red(backend):
    if backend == "osmesa" and not has_system_osmesa():
        pytest.skip("this system has no OSMesa")
    if backend == "osmesa from a package" and not has_package():
        pytest.skip("set-up installs the package only where nothing else draws")
    if backend == "egl" and choose_backend() != "egl":
        pytest.skip("this system has no EGL")
    done = in_a_process(MUJOCO_GL=backend)
    assert (done.stdout.strip(), done.stderr) == (f"{backend},255,0,0,255,0,0", "")


@pytest.mark.slow
def test_an_unknown_opengl_backend_is_a_one_line_error_with_a_remedy():
    done = in_a_process(MUJOCO_GL="nonsense")
    assert done.returncode == 1
    assert done.stderr == "MUJOCO_GL is 'nonsense'; mjsim draws with 'egl' or 'osmesa'; type: unset MUJOCO_GL\n"


@pytest.mark.slow
def test_an_egl_without_drivers_is_passed_over_unless_it_is_wished_for():
    wished = in_a_process(MUJOCO_GL="egl", **NO_VENDOR)
    assert wished.returncode == 1
    assert wished.stderr.startswith("cannot draw pictures (egl: ")
    assert wished.stderr.endswith("; type: unset MUJOCO_GL\n")
    free = in_a_process(**NO_VENDOR)
    if has_system_osmesa() or has_package():
        assert free.stdout.startswith("osmesa")
    else:
        assert free.stderr.startswith("cannot draw pictures (egl: ")
        assert free.stderr.endswith((f"; type: {CHECKOUT}/scripts/setup\n", f"; type: {APT_LINE}\n"))


@pytest.mark.slow
def test_who_installed_a_wheel_is_advised_what_works_there(tmp_path):
    if has_system_osmesa() or has_package():
        pytest.skip("something else than EGL draws here")
    shutil.copytree(CHECKOUT / "mjsim", tmp_path / "mjsim", ignore=shutil.ignore_patterns("page", "__pycache__"))
    advised = in_a_process(tmp_path, PYTHONPATH=str(tmp_path), **NO_VENDOR).stderr
    assert advised.startswith("cannot draw pictures (egl: ")
    locked = (CHECKOUT / "scripts" / "bootstrap" / "osmesa.in").read_text().split()[-1]
    wheel = how_to_install("--no-deps", locked) if sys.version_info < (3, 14) else APT_LINE
    assert advised.endswith((f"; type: {wheel}\n", f"; type: {APT_LINE}\n"))


def test_a_request_that_would_end_the_import_of_mujoco_is_moved_out_of_its_way(monkeypatch):
    monkeypatch.delenv("MJSIM_GL", raising=False)
    for harmless in ("", "glfw", "off"):
        monkeypatch.setenv("MUJOCO_GL", harmless)
        hide_request_from_mujoco()
        assert os.environ["MUJOCO_GL"] == harmless
    monkeypatch.setenv("MUJOCO_GL", "OSMesa from a package")
    hide_request_from_mujoco()
    assert "MUJOCO_GL" not in os.environ
    assert requested_backend() == "osmesa from a package"
    # Not by monkeypatch, which would put it back for all tests that follow.
    del os.environ["MJSIM_GL"]
