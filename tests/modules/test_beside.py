import gc
import importlib.util
import sys
from importlib.machinery import SourcelessFileLoader
from pathlib import Path
from py_compile import PycInvalidationMode, compile

import pytest

import mjsim
from mjsim.errors import UsageError
from mjsim.modules import make_module, user_files
from mjsim.world import Source, Use, parse_world

BODY = "class My:\n    def start(self, *a): pass\n    def update(self, seen): {update}\n"


def put(folder: Path, **files: str) -> Path:
    """Write files of Python, `pkg__name` for pkg/name.py."""
    for name, text in files.items():
        path = folder / f"{name.replace('___', '/')}.py"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return folder


def made(source: Source | Path, file: str = "mine.py"):
    source = source if isinstance(source, Source) else Source(folder=source)
    return make_module(Use(use=f"{file}:My"), source, role="estimator", robot="scout")


def module_of(instance: object):
    return sys.modules[type(instance).__module__]


@pytest.mark.parametrize("file", ["mine", "helper"])
def test_bytecode_beside_a_file_is_neither_run_nor_written(tmp_path, file):
    put(tmp_path, mine="from helper import said\nsaid_here = 'source'\n" + BODY.format(update="pass"))
    put(tmp_path, helper="said = 'source'\n")
    (tmp_path / "evil.py").write_text((tmp_path / f"{file}.py").read_text().replace("'source'", "'bytecode'"))
    cached = importlib.util.cache_from_source(tmp_path / f"{file}.py")
    compile(str(tmp_path / "evil.py"), cached, invalidation_mode=PycInvalidationMode.UNCHECKED_HASH)
    module = module_of(made(tmp_path))
    assert (module.said, module.said_here) == ("source", "source")
    assert [path.name for path in tmp_path.rglob("*.pyc")] == [Path(cached).name]


def test_bytecode_and_libraries_without_source_are_not_imported(tmp_path):
    put(tmp_path, mine="import helper\n" + BODY.format(update="pass"), pkg___inner="", gone="said = 1\n")
    for name in ("helper", "pkg/__init__", "pkg/inner"):
        compile(str(tmp_path / "gone.py"), str(tmp_path / f"{name}.pyc"))
        (tmp_path / f"{name}.so").write_bytes(b"\x7fELF")
    assert SourcelessFileLoader("helper", str(tmp_path / "helper.pyc")).get_code("helper") is not None
    with pytest.raises(mjsim.ModuleFault, match=r"raised ModuleNotFoundError: No module named 'helper' \(mine.py:1\)"):
        made(tmp_path)
    put(tmp_path, mine="from pkg.gone import said\n" + BODY.format(update="pass"))
    with pytest.raises(mjsim.ModuleFault, match=r"No module named 'pkg\.gone'"):
        made(tmp_path)


def test_each_run_imports_anew_and_the_modules_of_a_run_share_what_they_import(tmp_path):
    put(
        tmp_path, mine="import helper\n" + BODY.format(update="import helper as again, late; return again.said, late.x")
    )
    put(tmp_path, helper="said = 'first'\nclass Shared: pass\n", late="x = 1\n")
    first = Source(folder=tmp_path)
    old, partner = made(first), made(first)
    assert module_of(old) is not module_of(partner)
    assert module_of(old).helper is module_of(partner).helper
    put(tmp_path, helper="said = 'second'\n", late="x = 2\n")
    new = made(Source(folder=tmp_path))
    assert (old.update(None), partner.update(None)[0], new.update(None)) == (("first", 2), "first", ("second", 2))


@pytest.mark.slow
def test_nothing_else_sees_what_is_imported_beside_a_world_and_it_goes_with_the_module(tmp_path):
    put(tmp_path, mine="import helper\n" + BODY.format(update="pass"), helper="")
    before, paths, finders = set(sys.modules), list(sys.path), list(sys.meta_path)
    instance = made(tmp_path)
    # What else mjsim loads on first use stays loaded.
    names = {name for name in set(sys.modules) - before if name.rpartition(".")[2] in ("mine", "helper")}
    assert len(names) == 2
    assert "helper" not in sys.modules
    assert sys.path == paths
    assert importlib.util.find_spec("helper") is None
    del instance
    gc.collect()
    assert not names & set(sys.modules)
    assert sys.meta_path == finders


def test_a_module_that_cannot_be_made_leaves_nothing(tmp_path):
    put(tmp_path, mine="import helper\nraise ValueError\n", helper="")
    before, finders = set(sys.modules), list(sys.meta_path)
    with pytest.raises(mjsim.ModuleFault, match="ValueError"):
        made(tmp_path)
    assert set(sys.modules) == before
    assert sys.meta_path == finders


IMPORTS = {
    "a package": (
        "import pkg.sub as s; x = s.x",
        {"pkg___sub": "from . import base\nx = base.x", "pkg___base": "x = 1"},
    ),
    "a dotted name": ("import pkg.sub; x = pkg.sub.x", {"pkg___sub": "x = 1", "pkg_____init__": ""}),
    "from a package": ("from pkg import sub; x = sub.x", {"pkg___sub": "x = 1", "pkg_____init__": ""}),
    "all of it": ("from helper import *", {"helper": "x = 1"}),
    "its own folder": ("from . import helper; x = helper.x", {"helper": "x = 1"}),
    "from its own folder": ("from .helper import x", {"helper": "x = 1"}),
    "a circle": ("x = 1\nimport helper", {"helper": "from mine import x as y\nassert y == 1"}),
    "by hand": ("x = __import__('helper').x", {"helper": "x = 1"}),
    "like a library": ("import shapely; x = shapely.x", {"shapely": "x = 1"}),
    "like a part of Python": ("import queue; x = 1 if hasattr(queue, 'Queue') else 2", {"queue": "x = 2"}),
    "one of another system": (
        "try:\n    import winreg as w; x = 2\nexcept ImportError:\n    x = 1",
        {"winreg": "x = 2"},
    ),
    "a second try": (
        "for _ in range(2):\n    try:\n        import helper; x = 2\n    except ZeroDivisionError:\n        x = 1",
        {"helper": "1 / 0"},
    ),
    "a dataclass": (
        "from dataclasses import dataclass\n@dataclass\nclass D:\n    x: 'int'\nx = D(1).x",
        {},
    ),
}


@pytest.mark.parametrize(("text", "files"), IMPORTS.values(), ids=IMPORTS)
def test_imports_mean_what_they_do_in_a_script(tmp_path, text, files):
    libraries = {name: sys.modules.get(name) for name in ("shapely", "queue", "winreg")}
    put(tmp_path, mine=f"{text}\n" + BODY.format(update="pass"), **files)
    seen: list[str] = []
    source = Source(folder=tmp_path, admit=lambda path, data: seen.append(path.relative_to(tmp_path).as_posix()))
    assert module_of(made(source)).x == 1
    assert {name: sys.modules.get(name) for name in libraries} == libraries
    # All that ran is told beforehand, but for what is imported by hand.
    world = "robots: [{name: a, at: [0, 0]}]\nrun: {drivers: {a: {estimator: {use: 'mine.py:My'}}}}"
    told = user_files(parse_world(world, source=Source(folder=tmp_path)))
    assert set(seen) - {"helper.py"} <= set(told)
    assert "__import__" in text or set(seen) <= set(told)


@pytest.mark.parametrize("file", ["mine.py", "helper.py", "late.py"])
def test_a_file_whose_content_may_not_run_does_not(tmp_path, file):
    put(tmp_path, mine="import helper\n" + BODY.format(update="import late"))
    put(tmp_path, helper="", late="")
    allowed = {path.name: path.read_bytes() for path in tmp_path.iterdir()}

    def admit(path: Path, data: bytes) -> None:
        if allowed[path.name] != data:
            raise UsageError(f"{path.name} may not run")

    with (tmp_path / file).open("a") as text:
        text.write("open(__file__ + '.ran', 'w')\n")
    with pytest.raises(UsageError, match=f"{file} may not run"):
        made(Source(folder=tmp_path, admit=admit)).update(None)
    assert not list(tmp_path.glob("*.ran"))
