"""The direction of imports that the design settles: up its table, never down."""

import ast
from pathlib import Path

import pytest

import mjsim

ROOT = Path(mjsim.__file__).parent

FIRST = {"closing", "errors", "geometry", "gl_request"}
WORLD = FIRST | {"world"}
VALUES = WORLD | {"interface", "readings"}
COMPILE = VALUES | {"compile"}
RECORD = VALUES | {"record"}
SIM = COMPILE | {"sim"}
RUN = SIM | {"record", "safety", "run"}
VIDEO = RECORD | {"compile", "sim", "video"}
SESSION = RUN | {"session"}
REPORT = WORLD | {"record", "report"}
SWEEP = RUN | REPORT | {"sweep"}
MAY_IMPORT = {
    "closing": set(),
    "errors": set(),
    "geometry": set(),
    "gl_request": set(),
    "world": WORLD,
    "readings": {"geometry"},
    "interface": {"geometry", "readings"},
    "compile": COMPILE,
    "exchange": COMPILE | {"exchange"},
    "record": RECORD,
    "sim": SIM,
    "safety": {"interface", "geometry", "safety"},
    "run": RUN,
    "session": SESSION,
    "env": RUN | {"env"},
    "report": REPORT,
    # A log is told in ticks to a pilot, and stands in the world that the simulation would have.
    "logs": RUN | {"logs"},
    "sweep": SWEEP,
    "video": VIDEO,
    "experiments": RUN | REPORT | {"experiments", "algorithms"},
    "web": SWEEP | VIDEO | {"exchange", "session", "web"},
}
"""Part of mjsim -> the parts that it may import; `cli`, all `..._cli`, `doctor`, `bench` and `progress` are not."""

MAY_USE_MUJOCO = {"compile", "sim", "env", "doctor", "bench"}


@pytest.fixture(scope="module")
def imports():
    """Part, file and module of each import in the package."""
    return list(parts_and_imports())


def parts_and_imports():
    for file in sorted(ROOT.rglob("*.py")):
        part = file.relative_to(ROOT).parts[0].removesuffix(".py")
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.Import):
                yield from ((part, file, alias.name) for alias in node.names)
            elif isinstance(node, ast.ImportFrom):
                assert node.level == 0, f"{file} imports relatively"
                yield part, file, node.module


def test_imports_point_up_the_table(imports):
    seen = set()
    for part, file, module in imports:
        if part not in MAY_IMPORT or not (module == "mjsim" or module.startswith("mjsim.")):
            continue
        other = module.partition("mjsim.")[2].partition(".")[0]
        assert other in MAY_IMPORT[part], f"{file} imports {module}"
        seen.add(part)
    assert seen >= {"world", "compile", "record", "sim", "run", "report", "video"}


def test_every_part_of_the_package_stands_in_the_table():
    parts = {path.stem for path in ROOT.iterdir() if path.suffix == ".py" or (path / "__init__.py").exists()}
    commands = {part for part in parts if part.endswith("_cli")}
    assert parts - commands - set(MAY_IMPORT) <= {"__init__", "cli", "doctor", "bench", "progress"}


def test_only_the_parts_that_build_and_move_the_scene_import_mujoco(imports):
    users = {part for part, _, module in imports if module.partition(".")[0] == "mujoco"}
    assert users <= MAY_USE_MUJOCO
    assert users >= {"compile", "sim"}


def test_algorithms_import_of_mjsim_only_what_a_user_would():
    folder = Path(mjsim.__file__).parent.parent / "algorithms"
    files = sorted(folder.glob("*.py"))
    assert len(files) > 1
    for file in files:
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.ImportFrom) and node.level == 0 and node.module.startswith("mjsim"):
                public = node.module == "mjsim" or node.module in ("mjsim.interface", "mjsim.geometry")
                assert public, f"{file} imports {node.module}"
