"""The direction of imports that the design settles: one way, through faces, in no circle."""

import ast
import importlib
import re
import runpy
import sys
from pathlib import Path

import pytest

import mjsim
from mjsim.bench import import_graph
from mjsim.bench.import_graph import Package
from tests.children import completed

ROOT = Path(mjsim.__file__).parent

GROUND = {
    *("closing", "errors", "faces", "geometry", "gl_request", "guarded", "inventory", "output", "progress"),
    *("sentences", "spelling", "syntax", "traces", "views"),
}
WORLD = GROUND | {"mechanics", "models", "people", "world"}
VALUES = WORLD | {"interface"}
COMPILE = VALUES | {"compile", "posture", "style"}
PLAN = WORLD | {"posture", "plan"}
RECORD = VALUES | PLAN | {"record"}
LIGHT = COMPILE | {"light"}
SIM = LIGHT | {"modules", "sim"}
RUN = SIM | {"record", "safety", "run"}
VIDEO = RECORD | {"compile", "posture", "sim", "video"}
REPORT = PLAN | {"record", "report"}
SWEEP = RUN | REPORT | {"sweep"}
MAY_IMPORT = {
    **dict.fromkeys(GROUND, GROUND),
    "mechanics": GROUND,
    "interface": GROUND | {"mechanics"},
    "models": GROUND,
    "people": GROUND | {"mechanics"},
    "world": WORLD,
    # Pictures are judged by the recogniser that is shipped.
    "modules": VALUES | {"algorithms"},
    # Inverse kinematics of figures, which stand as it says in the compiled world.
    "posture": WORLD | {"people"},
    "compile": COMPILE,
    "style": WORLD | {"style"},
    "light": LIGHT,
    "plan": PLAN,
    # Robots that are brought in are measured.
    "exchange": SIM | PLAN,
    "record": RECORD,
    "sim": SIM,
    "safety": GROUND | {"interface"},
    # Messages of ROS 2, which the bridge sends and bags hold.
    "ros": VALUES,
    "datasets": SIM | {"record", "ros", "exchange"},
    "run": RUN,
    "session": RUN,
    "env": RUN,
    "report": REPORT,
    # A log is told in ticks to a pilot, and stands in the world that the simulation would have.
    "logs": RUN,
    "bridge": RUN | {"exchange", "ros", "session"},
    "sweep": SWEEP | {"toolbox"},
    # What notebooks show of all of them; they do not import it.
    "notebook": {*SWEEP, "lab"},
    "video": VIDEO,
    # Octave is found as for modules; arms that move become films.
    "toolbox": VIDEO | {"modules"},
    "lab": RUN | REPORT | {"algorithms"},
    "ergonomics": SIM | REPORT,
    "experiments": RUN | REPORT | {"algorithms"},
    "web": SWEEP | VIDEO | {"exchange", "session", "toolbox"},
}
"""Part of mjsim -> the other parts that it may import; some are still to come."""
MAY_IMPORT_ALL = {"__init__", "bench", "cli", "doctor"}

MAY_USE_MUJOCO = {"ergonomics", "lab", "light", "models", "posture", "compile", "sim", "env", "doctor", "bench"}

HEAVY = {
    *("av", "cv2", "dm_control", "ezdxf", "filterpy", "foxglove", "matplotlib", "mcap", "mink", "mujoco", "pyarrow"),
    *("ruamel", "scipy", "starlette", "svgpathtools", "trimesh", "uvicorn"),
}


ONE_WORD_TWICE = {
    "NoiseFigure": "the page is told what `world` finds, as JSON",
    "Signal": "the navigator of that name takes the keys of a signal; modules that are public keep their names",
}
"""Public classes of two parts with one name, and why."""


@pytest.fixture(scope="module")
def package():
    return Package(ROOT)


def test_imports_point_one_way(package):
    assert import_graph.wrong_directions(package, MAY_IMPORT) == []


def test_the_table_of_imports_on_the_page_of_the_architecture_is_that_of_the_sources(package):
    drawing = runpy.run_path(str(ROOT.parent / "scripts" / "make" / "architecture_picture.py"))
    page = (ROOT.parent / "docs" / "architecture.md").read_text(encoding="utf-8")
    assert drawing["with_table"](page, drawing["table"](drawing["parts_and_imports"](package))) == page


def test_every_part_of_the_package_stands_in_the_table():
    parts = {path.stem for path in ROOT.iterdir() if path.suffix == ".py" or (path / "__init__.py").exists()}
    assert parts - set(MAY_IMPORT) <= MAY_IMPORT_ALL


def test_packages_are_imported_through_their_faces(package):
    assert import_graph.past_faces(package) == []


def test_no_module_imports_the_face_that_it_stands_behind(package):
    assert import_graph.own_faces(package) == []


def test_no_module_imports_itself_by_way_of_others(package):
    assert import_graph.module_cycle(package) == []


def test_no_package_imports_itself_by_way_of_others(package):
    assert import_graph.package_cycle(package) == []


def test_only_the_parts_that_build_and_move_the_scene_import_mujoco(package):
    users = {package.part(each.importer) for each in package.imports if each.module.partition(".")[0] == "mujoco"}
    assert users <= MAY_USE_MUJOCO
    assert users >= {"compile", "sim"}


def test_algorithms_import_of_mjsim_only_what_a_user_would():
    # The face of the package is of mjsim itself.
    files = sorted(file for file in (ROOT.parent / "algorithms").rglob("*.py") if file.name != "__init__.py")
    assert len(files) > 1
    for file in files:
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.ImportFrom) and node.level == 0 and node.module.startswith("mjsim"):
                public = node.module in ("mjsim", "mjsim.geometry", "mjsim.interface", "mjsim.mechanics")
                assert public, f"{file} imports {node.module}"


def test_each_face_offers_what_its_stub_says(package):
    assert len(package.faces) > 20
    for name, offered in package.faces.items():
        assert set(importlib.import_module(name).__all__) == set(offered), name


def test_no_name_of_a_face_is_hidden_by_a_module_that_somebody_imports_first():
    for stub in ROOT.rglob("__init__.pyi"):
        for module, name in re.findall(r"^from \.([\w.]+) import (\w+) as", stub.read_text(), re.MULTILINE):
            assert module == name or not (stub.parent / f"{name}.py").exists(), f"{stub}: {name}"


def test_one_class_one_name(package):
    found = import_graph.shared_names([package, Package(ROOT.parent / "algorithms")])
    assert {name: parts for name, parts in found.items() if name not in ONE_WORD_TWICE} == {}
    assert set(ONE_WORD_TWICE) <= set(found)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("code", "heavy"),
    [
        ("import mjsim", HEAVY | {"numpy", "pydantic", "shapely"}),
        ("from mjsim.cli import main; sys.argv = ['mjsim', '--help']; main()", HEAVY | {"numpy", "shapely"}),
        ("from mjsim import Simulation", {"av", "filterpy", "foxglove", "matplotlib", "mcap", "scipy"}),
        (f"import mjsim; mjsim.load_world('{ROOT.parent}/worlds/gallery.yaml')", HEAVY),
        (
            "from mjsim.exchange import BroughtRobot, RobotOptions, bring_file, bring_robot",
            HEAVY | {"numpy", "shapely"},
        ),
        # The studio prints its address before it loads these.
        (
            "import mjsim.cli.studio_command, mjsim.web.studio; mjsim.cli.studio_command.opened('gallery')",
            HEAVY - {"starlette", "uvicorn"},
        ),
        (
            # Without pictures, which the recogniser judges.
            f"from mjsim.cli import main; sys.argv = ['mjsim', 'check', '{ROOT.parent}/worlds/avoidance.yaml']; main()",
            HEAVY
            | {
                "shapely",
                "mjsim.interface.values",
                "mjsim.mechanics",
                "mjsim.models.model_sources",
                "mjsim.cli.run_commands",
            },
        ),
    ],
)
def test_what_is_heavy_is_loaded_only_where_it_is_used(code, heavy):
    shown = f"import atexit, sys; atexit.register(lambda: print('LOADED', *sorted({heavy} & set(sys.modules)))); {code}"
    done = completed([sys.executable, "-c", shown])
    assert done.stdout.splitlines()[-1] == "LOADED"


@pytest.mark.slow
def test_a_run_of_a_rolling_robot_loads_nothing_of_arms_mechanisms_people_or_the_laboratory():
    done = completed(
        [
            *(sys.executable, "-c"),
            "import sys, mjsim; world = mjsim.load_world(sys.argv[1], settings={'run.seconds': 0.2}); mjsim.run(world);"
            "print(*sorted(name for name in sys.modules if name.startswith('mjsim.')))",
            f"{ROOT.parent}/worlds/avoidance.yaml",
        ]
    )
    loaded = done.stdout.split()
    assert "mjsim.sim.bases.differential" in loaded
    apart = re.compile(
        r"mjsim\.(ergonomics|lab|people|posture|toolbox|models\.arms|compile\.(arm|mechanism|person)_"
        r"|sim\.(arm_motion|person_hands)"
        r"|sim\.mechanisms\.(?!world_mechanisms$)|mechanics\.(?!motion$|sensed_values$|signal_functions$|transforms$))"
    )
    assert [name for name in loaded if apart.match(name)] == []


# The tests above can fail: small packages that break each rule.

OFFENDERS = {
    "down the table, in a function": (
        import_graph.wrong_directions,
        {"low/__init__.py": "", "low/a.py": "def f():\n    from house.high import x\n", "high/__init__.py": "x = 1\n"},
    ),
    "down the table, for types only": (
        import_graph.wrong_directions,
        {
            "low/__init__.py": "",
            "low/a.py": "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from house.high import x\n",
            "high/__init__.py": "",
        },
    ),
    "down the table, in a string": (
        import_graph.wrong_directions,
        {"low/__init__.py": "LATER = {'x': 'house.high'}\n", "high/__init__.py": ""},
    ),
    "down the table, in a stub": (
        import_graph.wrong_directions,
        {"low/__init__.py": "", "low/__init__.pyi": "from ..high import x as x\n", "high/__init__.py": ""},
    ),
    "past a face": (
        import_graph.past_faces,
        {
            "high/__init__.py": "",
            "high/a.py": "from house.low.b import x\n",
            "low/__init__.py": "",
            "low/b.py": "x = 1\n",
        },
    ),
    "a module past a face": (
        import_graph.past_faces,
        {"high/__init__.py": "", "high/a.py": "from house.low import b\n", "low/__init__.py": "", "low/b.py": ""},
    ),
    "past the face of a package within one's own": (
        import_graph.past_faces,
        {
            "low/__init__.py": "",
            "low/one/__init__.py": "",
            "low/one/a.py": "import house.low.two.b\n",
            "low/two/__init__.py": "",
            "low/two/b.py": "",
        },
    ),
    "one's own face": (
        import_graph.own_faces,
        {"low/__init__.py": "", "low/a.py": "from house.low import x\n"},
    ),
    "two modules in a circle": (
        import_graph.module_cycle,
        {"a.py": "import house.b\n", "b.py": "def f():\n    from house.a import x\n"},
    ),
    "two modules in a circle through a face": (
        import_graph.module_cycle,
        {
            "low/__init__.py": "",
            "low/__init__.pyi": "from .b import x as x\n",
            "low/b.py": "from house.a import y\nx = 1\n",
            "a.py": "from house.low import x\ny = 1\n",
        },
    ),
    "two packages in a circle, their modules in none": (
        import_graph.package_cycle,
        {
            "low/__init__.py": "",
            "low/__init__.pyi": "from .b import x as x\n",
            "low/b.py": "x = 1\n",
            "low/c.py": "from house.high import y\n",
            "high/__init__.py": "",
            "high/__init__.pyi": "from .a import y as y\n",
            "high/a.py": "from house.low import x\ny = x\n",
        },
    ),
}


def offences(rule, package):
    return rule(package, {"low": set()}) if rule is import_graph.wrong_directions else rule(package)


def house(folder, files):
    for name, text in {"__init__.py": "", **files}.items():
        path = folder / "house" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return Package(folder / "house")


@pytest.mark.parametrize(("rule", "files"), OFFENDERS.values(), ids=OFFENDERS)
def test_an_offender_is_found(rule, files, tmp_path):
    assert offences(rule, house(tmp_path, files))


def test_a_name_of_two_parts_is_found_behind_a_face_too(tmp_path):
    files = {
        "low/__init__.py": "",
        "low/__init__.pyi": "from .b import Wheel as Wheel\n",
        "low/b.py": "Wheel = float\nclass _Own: ...\n",
        "high/__init__.py": "",
        "high/a.py": "class Wheel: ...\nclass _Own: ...\nclass Hub: ...\n",
        "high/c.py": "class Hub: ...\n",
    }
    assert import_graph.shared_names([house(tmp_path, files)]) == {"Wheel": {"high", "low"}}


def test_a_package_in_order_is_left_alone(tmp_path):
    package = house(
        tmp_path,
        {
            "low/__init__.py": "",
            "low/__init__.pyi": "from .b import x as x\nfrom . import c as c\n",
            "low/b.py": "from house.low.c import y\nx = y\n",
            "low/c.py": "y = 1\n",
            "high/__init__.py": "",
            "high/a.py": "from house.low import c, x\n",
        },
    )
    rules = {rule for rule, _ in OFFENDERS.values()}
    assert [offences(rule, package) for rule in rules] == [[] for _ in rules]


def test_faces_of_what_has_a_file_a_kind_are_what_their_modules_define():
    for path, text in runpy.run_path(str(ROOT.parent / "scripts" / "make" / "faces.py"))["faces"]().items():
        assert path.read_text(encoding="utf-8") == text, f"{path}: run scripts/make/faces.py"


def test_no_script_imports_from_tests():
    scripts = (ROOT.parent / "scripts").rglob("*.py")
    wrong = ("sys.path.insert", "sys.path.append", "from tests", "import tests")
    assert [file for file in scripts if any(text in file.read_text() for text in wrong)] == []
