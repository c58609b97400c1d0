"""Write the faces that offer what is defined in one file per kind: mjsim.interface, and the drives of mjsim.world.

These are all of mjsim/interface/__init__.pyi and of mjsim/world/items/drives/__init__.pyi, and the lines that name them
in the faces above.

    python scripts/make/faces.py
"""

import ast
from collections.abc import Sequence
from pathlib import Path

MJSIM = Path(__file__).resolve().parents[2] / "mjsim"
INTERFACE, DRIVES = MJSIM / "interface", MJSIM / "world" / "items" / "drives"
WIRE = {"doubles", "forms", "json_form", "sweeps", "trees"}
"""Modules of the interface whose names `mjsim` itself does not offer."""
NOT_FOR_USERS = {"MAX_MESSAGE_LENGTH", "MAX_TEXT_LENGTH", "MAX_CELLS", "MAX_ITEMS", "MAX_POINTS"}
NOT_FOR_USERS |= {"Picture", "message_text", "require_bounds"}
"""Further names of the interface that `mjsim` itself does not offer."""
ITEMS_ONLY = {
    "KINDS",
    "OWN_IMU",
    "OwnImu",
    "SIDES",
    "Acceleration",
    "Speed",
    "Torque",
    "TurnAcceleration",
    "TurnRate",
    "geared_motor",
    "half_width",
}
"""Names of the drives that `mjsim.world` does not offer."""


def faces() -> dict[Path, str]:
    """Return the text of each face."""
    hidden = NOT_FOR_USERS.union(name for module, name in _defined(INTERFACE) if module in WIRE)
    users = [name for name in _names(INTERFACE) if name not in hidden]
    drives = [name for name in _names(DRIVES) if name not in ITEMS_ONLY]
    return {
        _face(INTERFACE): _own(INTERFACE),
        _face(DRIVES): _own(DRIVES),
        _face(MJSIM): _with_lines(MJSIM, "interface", users),
        _face(DRIVES.parent): _with_lines(DRIVES.parent, "drives", drives),
        _face(MJSIM / "world"): _with_names(MJSIM / "world", "items", drives),
    }


def _face(folder: Path) -> Path:
    return folder / "__init__.pyi"


def _own(folder: Path) -> str:
    """Return a face that offers all that the modules of its package define."""
    return "".join(f"from .{module} import {name} as {name}\n" for module, name in _defined(folder))


def _with_lines(folder: Path, package: str, names: Sequence[str]) -> str:
    """Return a face with these names of a package below it, and with no others of that package."""
    lines = _face(folder).read_text(encoding="utf-8").splitlines(keepends=True)
    return _sorted([line for line in lines if not line.startswith(f"from .{package} import ")], package, names)


def _with_names(folder: Path, package: str, names: Sequence[str]) -> str:
    """Return a face with these names of a package below it beside others of that package."""
    lines = _face(folder).read_text(encoding="utf-8").splitlines(keepends=True)
    offered = {line.split()[3] for line in lines if line.startswith(f"from .{package} import ")}
    others = [line for line in lines if not line.startswith(f"from .{package} import ")]
    return _sorted(others, package, sorted(offered | set(names), key=_order_of))


def _sorted(others: list[str], package: str, names: Sequence[str]) -> str:
    after = sum(line.startswith("from . import ") or line < f"from .{package}" for line in others)
    others[after:after] = [f"from .{package} import {name} as {name}\n" for name in names]
    return "".join(others)


def _names(folder: Path) -> list[str]:
    return sorted((name for _, name in _defined(folder)), key=_order_of)


def _defined(folder: Path) -> list[tuple[str, str]]:
    """Return module and name of all that the modules of a package define, in the order of imports."""
    found = []
    for file in folder.glob("*.py"):
        for node in ast.parse(file.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.ClassDef | ast.FunctionDef):
                found.append((file.stem, node.name))
            elif isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
                found.append((file.stem, node.targets[0].id))
            elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
                found.append((file.stem, node.target.id))
    public = [(module, name) for module, name in found if not name.startswith("_")]
    return sorted(public, key=lambda each: (each[0], _order_of(each[1])))


def _order_of(name: str) -> tuple[int, str, str]:
    """Constants, then classes, then functions, as imports are sorted."""
    return (0 if name.isupper() else 1 if name[0].isupper() else 2, name.lower(), name)


def main() -> None:
    """Write them."""
    for path, text in faces().items():
        path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
