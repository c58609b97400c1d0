import hashlib
import os
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from tests.children import completed

ROOT = Path(__file__).parent.parent
SCRIPTS = ROOT / "scripts"
HOSTS = [".".join(parts) for parts in (("pypi", "org"), ("pythonhosted", "org"), ("npmjs", "org"), ("anaconda", "org"))]


def tracked_files() -> list[Path]:
    done = completed(["git", "ls-files", "-z"], check=False, cwd=ROOT)
    if done.returncode:
        pytest.skip("this is no git checkout")
    return [path for name in done.stdout.split("\0") if name and (path := ROOT / name).is_file()]


@pytest.fixture
def checkout(tmp_path):
    """A folder with a space in its name that holds the set-up script and nothing to install."""
    folder = tmp_path / "a checkout"
    (folder / "scripts").mkdir(parents=True)
    shutil.copy(SCRIPTS / "setup", folder / "scripts")
    for name in ("requirements.lock", "requirements-dev.lock", "pyproject.toml", "setup.py"):
        (folder / name).touch()
    return folder


def set_up(checkout: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    return completed([checkout / "scripts" / "setup"], check=False, cwd="/", env={"PATH": os.defpath} | environment)


def python_that(folder: Path, name: str, refusal: str) -> str:
    """Write a stand-in for a Python that refuses some arguments and else is this one; return its path."""
    folder.mkdir(exist_ok=True)
    script = folder / name
    script.write_text(f'#!/bin/sh\n{refusal}\nexec "{Path(sys.executable).resolve()}" "$@"\n')
    script.chmod(0o755)
    return str(script)


def test_no_file_names_the_host_of_a_registry():
    texts = {path: path.read_bytes() for path in tracked_files()}
    assert not [f"{path}: {host}" for path, text in texts.items() for host in HOSTS if host.encode() in text]


@pytest.mark.slow
def test_the_wheel_holds_every_file_of_the_package_and_nothing_else(tmp_path):
    tracked = [path.relative_to(ROOT) for path in tracked_files()]
    for path in tracked:
        (tmp_path / "checkout" / path).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / path, tmp_path / "checkout" / path)
    command = [sys.executable, "-c", "import setuptools.build_meta as b, sys; b.build_wheel(sys.argv[1])", tmp_path]
    completed(command, cwd=tmp_path / "checkout")
    (wheel,) = tmp_path.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        packed = {name for name in archive.namelist() if ".dist-info/" not in name}
    assert packed == {name for path in tracked if (name := installed_as(path.as_posix()))}


def installed_as(path: str) -> str | None:
    """Return where a tracked file is installed; None for one that is not."""
    beside = {"algorithms/": "algorithms/", "assets/": "assets/", "tests/bench/": "bench/", "worlds/": "worlds/"}
    if path.startswith("mjsim/"):
        return None if path.startswith("mjsim/web/page/") else path
    return next((f"mjsim/{to}{path.removeprefix(at)}" for at, to in beside.items() if path.startswith(at)), None)


def test_the_pip_wheel_is_the_one_that_set_up_and_its_note_name():
    (wheel,) = (SCRIPTS / "bootstrap").glob("pip-*.whl")
    digest = hashlib.sha256(wheel.read_bytes()).hexdigest()
    for text in ((SCRIPTS / "setup").read_text(), (SCRIPTS / "bootstrap" / "pip-wheel.md").read_text()):
        assert wheel.name in text
        assert digest in text


def test_every_locked_package_has_its_hashes():
    for name in ("requirements.lock", "requirements-dev.lock", "scripts/bootstrap/osmesa.lock"):
        entries = re.split(r"\n(?=[a-z0-9])", (ROOT / name).read_text())
        assert all(re.match(r"[\w.-]+==[\w.]+", entry) and "--hash=sha256:" in entry for entry in entries)


def pins(lock: str) -> dict[str, str]:
    return dict(re.findall(r"^([\w.-]+)==([\w.]+)", (ROOT / lock).read_text(), re.MULTILINE))


def test_developers_have_what_users_have_at_the_same_versions():
    users, developers = pins("requirements.lock"), pins("requirements-dev.lock")
    assert users.items() < developers.items()


def test_a_user_installation_leaves_out_large_optional_packages():
    spared = {"pyarrow", "ezdxf", "usd-core", "gtsam", "distributed", "evo", "pandas", "playwright", "uv"}
    assert not spared & pins("requirements.lock").keys()
    assert {"mujoco", "dm-control", "numpy", "opencv-python-headless", "filterpy"} <= pins("requirements.lock").keys()


def test_an_unknown_word_for_set_up_is_refused_with_one_line(checkout):
    done = completed([checkout / "scripts" / "setup", "--users"], check=False)
    assert (done.returncode, done.stderr) == (
        1,
        "setup: '--users' is not known; type scripts/setup or scripts/setup --user\n",
    )


def test_a_python_that_does_not_suit_is_refused_with_one_line_and_nothing_is_made(checkout):
    done = set_up(checkout, MJSIM_PYTHON="/bin/false")
    assert done.returncode == 1
    assert done.stderr == "setup: MJSIM_PYTHON is /bin/false; it must be a Python 3.11 to 3.14\n"
    assert not (checkout / ".venv").exists()


@pytest.mark.slow
def test_a_python_that_is_on_the_path_but_does_not_start_is_passed_over(checkout, tmp_path):
    python_that(tmp_path / "bin", "python3.12", "exit 127")
    python_that(tmp_path / "bin", "python3.11", "")
    done = set_up(checkout, PATH=f"{tmp_path / 'bin'}:{os.defpath}")
    assert f"making .venv with Python {sys.version.split()[0]}" in done.stderr
    # There is no wheel in this checkout: it goes no further, and says so.
    assert done.returncode != 0


@pytest.mark.slow
def test_without_the_module_venv_set_up_makes_an_environment_of_its_own(checkout, tmp_path):
    python = python_that(tmp_path / "bin", "python3", '[ "$1" = -m ] && exit 1')
    set_up(checkout, MJSIM_PYTHON=python)
    show = "import sys, sysconfig; print(sys.prefix, sysconfig.get_path('purelib'), sep='\\n')"
    made = checkout / ".venv"
    done = completed([made / "bin" / "python", "-c", show])
    prefix, packages = done.stdout.split("\n")[:2]
    assert Path(prefix) == made
    assert Path(packages) == made / f"lib/python{sys.version_info[0]}.{sys.version_info[1]}/site-packages"
    assert Path(packages).is_dir()


@pytest.mark.slow
def test_a_test_that_hangs_is_ended_and_named(tmp_path):
    """Every test has the limit of pyproject.toml; here with a shorter one, and a wait that no Ctrl-C would end."""
    (tmp_path / "test_hang.py").write_text("import threading\n\n\ndef test_hang():\n    threading.Event().wait()\n")
    command = [sys.executable, "-m", "pytest", "-c", ROOT / "pyproject.toml", "--rootdir", tmp_path, "-o", "timeout=1"]
    command += ["--basetemp", tmp_path / "tmp"]
    done = completed([*command, tmp_path], check=False)
    assert done.returncode == 1
    assert "Failed: Timeout" in done.stdout
    assert "test_hang" in done.stdout


def test_tests_have_a_limit(pytestconfig):
    assert 0.0 < float(pytestconfig.getini("timeout")) <= 20.0
