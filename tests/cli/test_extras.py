"""What is heavy and rarely used is an extra; where it is missing, one line says how to install it."""

import importlib.util
import runpy
import shlex
import sys
from pathlib import Path

import pytest

import mjsim
from mjsim.cli import main
from mjsim.errors import UsageError, how_to_install
from mjsim.exchange import world_from_dxf
from tests.children import completed


@pytest.fixture
def without(monkeypatch):
    """Return what makes a package look as if it were not installed."""
    find = importlib.util.find_spec

    def hide(package: str) -> None:
        for name in [package, *(name for name in sys.modules if name.startswith(f"{package}."))]:
            monkeypatch.setitem(sys.modules, name, None)
        monkeypatch.setattr(importlib.util, "find_spec", lambda name, *more: None if name == package else find(name))

    return hide


def test_the_command_that_is_advised_works_in_this_environment():
    command = shlex.split(how_to_install("numpy"))
    completed([*command, "--dry-run"])


def test_pip_is_advised_where_there_is_pip(monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: name)
    assert how_to_install("ezdxf", "pyarrow") == f"{shlex.quote(sys.executable)} -m pip install ezdxf pyarrow"


def test_a_folder_with_a_space_is_quoted(monkeypatch):
    monkeypatch.setattr(sys, "executable", "/my robots/python")
    assert shlex.split(how_to_install("numpy")).count("/my robots/python") == 1


def test_uv_is_advised_where_there_is_no_pip(monkeypatch, tmp_path):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    monkeypatch.setenv("PATH", "/nowhere")
    monkeypatch.setattr(sys, "executable", str(tmp_path / "python"))
    assert how_to_install("ezdxf") == f"uv pip install --python {tmp_path}/python ezdxf"
    (tmp_path / "uv").touch(mode=0o755)
    assert how_to_install("ezdxf") == f"{tmp_path}/uv pip install --python {tmp_path}/python ezdxf"


def test_a_drawing_without_ezdxf(without, tmp_path):
    without("ezdxf")
    with pytest.raises(UsageError, match=r"^DXF files need ezdxf, which is not installed; type: .* ezdxf$"):
        world_from_dxf(tmp_path / "plan.dxf")


def test_videos_without_av_are_refused_before_the_run_and_all_else_loads(without, tmp_path):
    without("av")
    runpy.run_path(str(Path(mjsim.__file__).parent / "video" / "film.py"))
    with pytest.raises(UsageError, match=r"^videos need PyAV, which is not installed; type: .* av$"):
        mjsim.video.require_film_name(tmp_path / "run.mp4")


@pytest.mark.slow
def test_a_sweep_without_pyarrow_leaves_its_table_as_csv(without, tmp_path, capsys):
    without("pyarrow")
    sweep = ("sweep", "empty", "--seeds", "0:2", "--seconds", "0.2", "--workers", "1", "-o", str(tmp_path / "sweep"))
    with pytest.raises(SystemExit) as ended:
        main(sweep)
    out, err = capsys.readouterr()
    assert ended.value.code == 0
    assert out.splitlines()[-1] == str(tmp_path / "sweep" / "table.csv")
    assert f"mjsim: for the table as Parquet, install pyarrow: {how_to_install('pyarrow')}\n" in err
    assert not (tmp_path / "sweep" / "table.parquet").exists()
    assert len((tmp_path / "sweep" / "table.csv").read_text().splitlines()) == 3


@pytest.mark.parametrize(
    ("module", "package"), [("pxr", "usd-core"), ("distributed", "distributed"), ("cyclonedds", "cyclonedds")]
)
def test_other_extras(without, module, package, tmp_path, capsys):
    without(module)
    words = {
        "pxr": ("export-world", "empty", "--usd", str(tmp_path / "a.usda")),
        "distributed": ("sweep", "empty", "--seeds", "1", "-o", str(tmp_path / "s"), "--dask", "tcp://127.0.0.1:1"),
        "cyclonedds": ("bridge", "empty"),
    }
    with pytest.raises(SystemExit) as ended:
        main(words[module])
    line = capsys.readouterr().err.splitlines()[-1]
    assert ended.value.code == 2
    assert line.endswith(f"not installed; type: {how_to_install(package)}") or "not installed here; type: " in line
