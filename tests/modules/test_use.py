"""What `use:` names is found, judged by its text, made live and closed in one place."""

import os
import sys
from pathlib import Path

import pytest

import mjsim
from mjsim.cli import main
from mjsim.modules import Hosted, check_modules, load_runnable, make_module, missing_modules, modules_of, user_files
from mjsim.world import Source, Use, parse_world

MODULE = """
raise SystemExit("this must not run")
import math as geometry
from somewhere import Brought
class Avoid: pass
if True:
    class Inner: pass
Alias: type = Avoid
"""


@pytest.mark.parametrize(
    ("use", "doubt"),
    [
        ("mine.py:Avoid", None),
        ("mine.py:Inner", None),
        ("mine.py:Alias", None),
        ("mine.py:Brought", None),
        ("package/deep.py:Star", None),
        ("package/lazy.py:Late", None),
        ("mjsim.safety:RingAvoidance", None),
        ("mjsim.algorithms.ekf_slam:EkfSlam", None),
        ("collections:OrderedDict", None),
        ("math:Anything", None),
        ("mine.py:Avoyd", "no class 'Avoyd' in mine.py; did you mean 'Avoid'?"),
        ("min.py:Avoid", "no file 'min.py' beside the world file; did you mean 'mine.py'?"),
        ("../mine.py:Avoid", "path '../mine.py' is outside the folder of the world; keep it beside the world file"),
        ("broken.py:Avoid", "broken.py:2: '(' was never closed; this is not Python"),
        ("mjsim.algorithms.textbook:TextbookFastSlam", None),
        (
            "mjsim.algorithms.textbook:TextbookFastSlm",
            "no class 'TextbookFastSlm' in mjsim.algorithms.textbook; did you mean 'TextbookFastSlam'?",
        ),
        ("mjsim.algorithms:EkfSlm", "no class 'EkfSlm' in mjsim.algorithms; did you mean 'EkfSlam'?"),
        ("mjsim.algorithms.ekf_slam:EkfSlm", "no class 'EkfSlm' in mjsim.algorithms.ekf_slam; did you mean 'EkfSlam'?"),
        ("mjsim.algorithms.none:X", "no module 'mjsim.algorithms.none' is installed; install it or correct the name"),
        (
            "mjsim.algorithms.ekfslam:EkfSlam",
            "no module 'mjsim.algorithms.ekfslam' is installed; did you mean 'mjsim.algorithms.ekf_slam'?",
        ),
        ("none.such:X", "no module 'none' is installed; install it or correct the name"),
        ("not a module:X", "'not a module' is not a module; write 'package.module:Class' or 'file.py:Class'"),
    ],
)
def test_classes_are_looked_for_without_running_anything(tmp_path, use, doubt):
    (tmp_path / "mine.py").write_text(MODULE)
    (tmp_path / "broken.py").write_text("x = 1\ny = (\n")
    (tmp_path / "package").mkdir()
    (tmp_path / "package" / "deep.py").write_text("from mine import *\n")
    (tmp_path / "package" / "lazy.py").write_text("__getattr__, __dir__ = attach(__name__)\n")
    text = f"robots: [{{name: a, at: [0, 0]}}]\nrun: {{drivers: {{a: {{navigator: {{use: '{use}'}}}}}}}}"
    world = parse_world(text, source=Source(file="w", folder=tmp_path))
    found = check_modules(world) if use.startswith("broken") else missing_modules(world)
    assert [str(problem) for problem in found] == ([f"w:2:38: {doubt}"] if doubt else [])


CLASSES = """
import dataclasses
from elsewhere import Base

class Good:
    def __init__(self, pace, *, gain=1.0): pass
    def start(self, robot, catalogue, rng): pass
    def update(self, seen): pass

class Child(Good):
    pass

class NoStart:
    def update(self, seen): pass

class Async(Good):
    async def update(self, seen): pass

class Borrowed(Base):
    pass

class Given(Good, metaclass=type):
    def __init__(self, **keys): pass

@dataclasses.dataclass
class Plain:
    pace: float
    def update(self, seen): pass

def build(pace):
    return Good(pace)
"""


def test_a_class_of_a_package_is_judged_by_the_file_that_defines_it():
    use = "mjsim.algorithms.textbook:TextbookFastSlam', partikles: 3"
    world = parse_world(f"robots: [{{name: a, at: [0, 0]}}]\nrun: {{drivers: {{a: {{estimator: {{use: '{use}}}}}}}}}")
    messages = [problem.message for problem in check_modules(world)]
    assert messages == ["TextbookFastSlam takes no 'partikles'; did you mean 'particles'?"]


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ("wander:Wander', speed: fast", "speed is 'fast'; it must be a number"),
        ("wander:Wander', speed: true", "speed is True; it must be a number"),
        ("waypoints:Waypoints', points: [[1, .nan]]", "points is [[1, nan]]; it must be without NaN"),
        ("wander:Wander', speed: .nan", "speed is nan; it must be without NaN"),
        ("explore:Explore', lidar: 3", "lidar is 3; it must be text or null"),
        ("go_to_goal:GoToGoal', goals: 5", "goals is 5; it must be a list"),
    ],
)
def test_a_value_of_another_kind_than_a_shipped_module_takes_is_told(keys, message):
    text = (
        f"robots: [{{name: a, at: [0, 0]}}]\nrun: {{drivers: {{a: {{navigator: {{use: 'mjsim.algorithms.{keys}}}}}}}}}"
    )
    assert [problem.message for problem in check_modules(parse_world(text))] == [message]


@pytest.mark.parametrize(
    ("used", "lines"),
    [
        ("Good', pace: 1", []),
        ("Child', pace: 1, gain: 2", []),
        ("Borrowed', anything: 1", []),
        ("Given', anything: 1", []),
        ("Plain', pace: 1", ["2:38: Plain in mine.py has no method start(); an estimator needs start() and update()"]),
        ("NoStart'", ["2:38: NoStart in mine.py has no method start(); an estimator needs start() and update()"]),
        (
            "Async', pace: 1",
            ["2:38: Async in mine.py has `async def update`; write `def update`, since the simulator does not await"],
        ),
        (
            "build', pace: 1",
            ["2:38: build in mine.py is a function; an estimator is a class with start() and update()"],
        ),
        ("Good', pase: 1, gain: 1", ["2:60: Good takes no 'pase'; did you mean 'pace'?"]),
        ("Child'", ["2:38: Child needs 'pace'; write it beside use"]),
    ],
)
def test_a_class_is_judged_by_its_text(tmp_path, used, lines):
    (tmp_path / "mine.py").write_text("raise SystemExit('this must not run')\n" + CLASSES)
    text = f"robots: [{{name: a, at: [0, 0]}}]\nrun: {{drivers: {{a: {{estimator: {{use: 'mine.py:{used}}}}}}}}}"
    world = parse_world(text, source=Source(file="w", folder=tmp_path))
    assert [str(problem) for problem in check_modules(world)] == [f"w:{line}" for line in lines]


DRIVEN = """
robots:
- {name: rover, at: [0, 0], body: {model: rover.xml, radius: 0.2, height: 0.2}, drive: {use: 'tank.py:Tank'}}
run: {drivers: {rover: {estimator: {use: 'mine.py:Good', pace: 1}, avoidance: {use: 'mine.py:Nothing'}}}}
"""


def test_a_drive_is_a_module_like_the_others(tmp_path):
    (tmp_path / "mine.py").write_text(CLASSES)
    (tmp_path / "rover.xml").write_text("<mujoco/>")
    world = parse_world(DRIVEN, source=Source(file="w", folder=tmp_path))
    assert [(named.robot, named.role, named.use.use) for named in modules_of(world)] == [
        ("rover", "drive", "tank.py:Tank"),
        ("rover", "estimator", "mine.py:Good"),
        ("rover", "avoidance", "mine.py:Nothing"),
    ]
    assert [str(problem) for problem in missing_modules(world)] == [
        "w:3:94: no file 'tank.py' beside the world file; there are mine.py",
        "w:4:85: no class 'Nothing' in mine.py; there are Async, Borrowed, Child, Given, Good, NoStart, Plain",
    ]
    (tmp_path / "tank.py").write_text("import mine\nclass Tank:\n    pass\n")
    assert sorted(user_files(world)) == ["mine.py", "tank.py"]
    assert str(check_modules(world)[0]) == (
        "w:3:94: Tank in tank.py has no methods wheels_from_twist() and twist_from_wheels();"
        " a drive needs wheels_from_twist() and twist_from_wheels()"
    )


def test_a_world_is_runnable_when_its_modules_are_there_even_if_they_do_not_fit(tmp_path):
    path = tmp_path / "room.yaml"
    text = "mjsim: 1\nrobots: [{name: a, at: [0, 0]}]\nrun: {drivers: {a: {navigator: {use: 'mine.py:NoStart'}}}}\n"
    path.write_text(text)
    with pytest.raises(mjsim.WorldError, match=r"room.yaml:3:38: no file 'mine.py' beside the world file"):
        load_runnable(path)
    (tmp_path / "mine.py").write_text(CLASSES)
    assert load_runnable(path).robots[0].name == "a"


def made(folder: Path, file: str, text: str, name: str, **keys: object):
    """Return an instance of a class in a file."""
    (folder / file).parent.mkdir(exist_ok=True)
    (folder / file).write_text(text)
    return make_module(Use(use=f"{file}:{name}", **keys), Source(folder=folder), role="estimator", robot="scout")


GOOD = "class Good:\n    def start(self, *a): pass\n    def update(self, seen): pass\n"


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("import nowhere_at_all\n", "raised ModuleNotFoundError: No module named 'nowhere_at_all' (mine.py:1)"),
        ("x = 1\ny = (\n", "raised SyntaxError: '(' was never closed (mine.py:2)"),
        ("import sys\nsys.exit(5)\n", "raised SystemExit: 5 (mine.py:2)"),
        ("raise type('Own', (BaseException,), {})('mine')\n", "raised Own: mine (mine.py:1)"),
        ("def f():\n    f()\nf()\n", "raised RecursionError: maximum recursion depth exceeded (mine.py:2)"),
        ("class Good: pass\n", "has no methods start() and update(); an estimator needs start() and update()"),
        ("def Good(): pass\n", "is a value of type function; an estimator is a class with start() and update()"),
        ("Good = 3\n", "is a value of type int; an estimator is a class with start() and update()"),
        (GOOD + "    def __init__(self): 1 / 0\n", "raised ZeroDivisionError: division by zero (mine.py:4)"),
        (GOOD + "    def __init__(self): raise SystemExit\n", "raised SystemExit (mine.py:4)"),
        (GOOD + "    def __new__(cls): raise MemoryError\n", "raised MemoryError (mine.py:4)"),
        (GOOD + "    async def update(self, seen): pass\n", "has `async def update`; write `def update`, since the"),
    ],
)
def test_what_goes_wrong_while_a_module_is_made_is_one_line_that_names_it(tmp_path, text, says):
    with pytest.raises(mjsim.ModuleFault) as caught:
        made(tmp_path, "mine.py", text, "Good")
    assert str(caught.value).startswith(f"estimator Good of robot 'scout' at 0.00 s {says}")
    assert str(caught.value).isprintable()
    assert caught.value.robot == "scout"


NO_START = "class My:\n    def command(self, seen, belief): pass\n"
EMPTY = "expected an indented block after class definition on line 1"
LACKS = "has no method start(); a navigator needs start() and command()"


@pytest.mark.parametrize(
    ("module", "words", "code", "line"),
    [
        (NO_START, ("run", "room.yaml"), 1, f"navigator My of robot 'a' at 0.00 s {LACKS}"),
        (NO_START, ("check", "room.yaml"), 2, f"room.yaml:2:38: My in my.py {LACKS}"),
        (
            "class My:\n",
            ("run", "room.yaml"),
            1,
            f"navigator My of robot 'a' at 0.00 s raised IndentationError: {EMPTY} (my.py:1)",
        ),
        ("class My:\n", ("check", "room.yaml"), 2, f"room.yaml:2:38: my.py:1: {EMPTY}; this is not Python"),
        (
            "import not_there\nclass My: pass",
            ("run", "room.yaml"),
            1,
            "navigator My of robot 'a' at 0.00 s raised ModuleNotFoundError: No module named 'not_there' (my.py:1)",
        ),
        ("class Me: pass", ("run", "room.yaml"), 2, "room.yaml:2:38: no class 'My' in my.py; there are Me"),
        pytest.param(
            NO_START,
            ("sweep", "room.yaml", "--seeds", "0:1", "-o", "out", "--workers", "1"),
            1,
            f"mjsim: run 000-seed0000 failed: navigator My of robot 'a' at 0.00 s {LACKS}",
            marks=pytest.mark.slow,
        ),
    ],
)
def test_the_command_line_says_so_in_one_line(tmp_path, capsys, monkeypatch, module, words, code, line):
    monkeypatch.chdir(tmp_path)
    Path("room.yaml").write_text("robots: [{name: a, at: [0, 0]}]\nrun: {drivers: {a: {navigator: {use: 'my.py:My'}}}}")
    Path("my.py").write_text(module)
    with pytest.raises(SystemExit) as left:
        main(list(words))
    err = capsys.readouterr().err
    assert left.value.code == code
    assert line in err.splitlines()
    assert "Traceback" not in err


def test_files_of_one_name_in_two_folders_are_two_modules(tmp_path):
    first = made(tmp_path / "a", "same_name.py", GOOD + "    at = 'a'\n", "Good")
    second = made(tmp_path / "b", "same_name.py", GOOD + "    at = 'b'\n", "Good")
    assert (first.at, second.at) == ("a", "b")
    for module in (first, second):
        assert vars(sys.modules[type(module).__module__])["Good"] is type(module)


def test_a_file_named_like_a_library_does_not_replace_it(tmp_path):
    import json

    made(tmp_path, "json.py", GOOD, "Good")
    assert sys.modules["json"] is json


class Engine(Hosted):
    """A module that holds something: it counts how often it was opened and closed."""

    def __init__(self, fails=False):
        self.fails, self.calls = fails, []

    name = "engine.m"

    def start(self, robot, map, rng):
        self.calls.append("start")

    def command(self, seen, belief):
        if self.fails and seen.time > 0.1:
            raise ValueError("stuck")
        return mjsim.Command(0.1)

    def close(self):
        self.calls.append("close")


@pytest.mark.parametrize("fails", [False, True])
def test_what_a_host_holds_is_closed_when_the_run_ends_and_named_in_faults(fails):
    engine = Engine(fails)
    with mjsim.Simulation(mjsim.parse_world("robots: [{name: scout, at: [0, 0]}]")) as sim:
        for _ in range(2):
            sim.reset(1)
            if fails:
                with pytest.raises(mjsim.ModuleFault, match=r"navigator engine\.m of robot 'scout' at 0\.12 s raised"):
                    mjsim.run(sim, drivers={"scout": mjsim.Driver(navigator=engine)}, seconds=0.4)
            else:
                mjsim.run(sim, drivers={"scout": mjsim.Driver(navigator=engine)}, seconds=0.4)
    assert engine.calls == ["start", "close"] * 2


def test_a_file_whose_name_no_world_can_hold_is_not_meant(tmp_path):
    (tmp_path / os.fsdecode(b"sla\xff.py")).touch()
    text = "robots: [{name: a, at: [0, 0]}]\nrun: {drivers: {a: {estimator: {use: 'sla.py:Slam'}}}}\n"
    (problem,) = check_modules(parse_world(text, source=Source(file="w", folder=tmp_path)))
    assert str(problem).endswith("no file 'sla.py' beside the world file; there are none")
