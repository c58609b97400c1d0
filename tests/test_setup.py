import hashlib
import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
SCRIPTS = ROOT / "scripts"
HOSTS = [".".join(parts) for parts in (("pypi", "org"), ("pythonhosted", "org"), ("npmjs", "org"), ("anaconda", "org"))]


def tracked_files() -> list[Path]:
    done = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=False)
    if done.returncode:
        pytest.skip("this is no git checkout")
    return [path for name in done.stdout.split("\0") if name and (path := ROOT / name).is_file()]


@pytest.fixture
def checkout(tmp_path):
    """A folder with a space in its name that holds the set-up script and nothing to install."""
    folder = tmp_path / "a checkout"
    (folder / "scripts").mkdir(parents=True)
    shutil.copy(SCRIPTS / "setup", folder / "scripts")
    for name in ("requirements.lock", "pyproject.toml"):
        (folder / name).touch()
    return folder


def set_up(checkout: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [checkout / "scripts" / "setup"],
        cwd="/",
        env={"PATH": os.defpath} | environment,
        capture_output=True,
        text=True,
        check=False,
    )


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


def test_every_package_that_is_installed_is_in_the_checkout():
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]
    places = settings["package-dir"]
    folders = [places.get(name, name.replace(".", "/")) for name in settings["packages"]]
    files = {str(path.relative_to(ROOT)) for path in tracked_files()}
    assert not [folder for folder in folders if f"{folder}/__init__.py" not in files]


def test_the_pip_wheel_is_the_one_that_set_up_and_its_note_name():
    (wheel,) = SCRIPTS.glob("pip-*.whl")
    digest = hashlib.sha256(wheel.read_bytes()).hexdigest()
    for text in ((SCRIPTS / "setup").read_text(), (SCRIPTS / "pip-wheel.md").read_text()):
        assert wheel.name in text
        assert digest in text


def test_every_locked_package_has_its_hashes():
    for name in ("requirements.lock", "scripts/osmesa.lock"):
        entries = re.split(r"\n(?=[a-z0-9])", (ROOT / name).read_text())
        assert all(re.match(r"[\w.-]+==[\w.]+", entry) and "--hash=sha256:" in entry for entry in entries)


def test_a_python_that_does_not_suit_is_refused_with_one_line_and_nothing_is_made(checkout):
    done = set_up(checkout, MJSIM_PYTHON="/bin/false")
    assert done.returncode == 1
    assert done.stderr == "setup: MJSIM_PYTHON is /bin/false; it must be a Python 3.11 to 3.14\n"
    assert not (checkout / ".venv").exists()


def test_a_python_that_is_on_the_path_but_does_not_start_is_passed_over(checkout, tmp_path):
    python_that(tmp_path / "bin", "python3.12", "exit 127")
    python_that(tmp_path / "bin", "python3.11", "")
    done = set_up(checkout, PATH=f"{tmp_path / 'bin'}:{os.defpath}")
    assert f"making .venv with Python {sys.version.split()[0]}" in done.stderr
    # There is no wheel in this checkout: it goes no further, and says so.
    assert done.returncode != 0


def test_without_the_module_venv_set_up_makes_an_environment_of_its_own(checkout, tmp_path):
    python = python_that(tmp_path / "bin", "python3", '[ "$1" = -m ] && exit 1')
    set_up(checkout, MJSIM_PYTHON=python)
    show = "import sys, sysconfig; print(sys.prefix, sysconfig.get_path('purelib'), sep='\\n')"
    made = checkout / ".venv"
    done = subprocess.run([made / "bin" / "python", "-c", show], capture_output=True, text=True, check=True)
    prefix, packages = done.stdout.split("\n")[:2]
    assert Path(prefix) == made
    assert Path(packages) == made / f"lib/python{sys.version_info[0]}.{sys.version_info[1]}/site-packages"
    assert Path(packages).is_dir()
