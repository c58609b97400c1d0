"""Files that a world names with `use:`: only regular files in its folder are read, shown or run, whatever the name."""

import json
import os
import socket
from contextlib import closing

import numpy as np
import pytest

import mjsim
from mjsim.errors import MjsimError, UsageError
from mjsim.geometry import Pose
from mjsim.interface import Estimate
from mjsim.modules import check_modules, foreign_code, make_module, user_files
from mjsim.modules.hosts import Failed
from mjsim.run import drivers_of
from mjsim.world import Source, Use, parse_world

CLASS = "class M:\n    def start(self, *told): pass\n    def command(self, seen, belief): pass\n"
PROGRAM = "#!/bin/sh\ncat\n"


@pytest.fixture
def folder(tmp_path):
    """A folder of a world, beside one with secrets, and what leads from it to them."""
    outside, home = tmp_path / "outside", tmp_path / "home"
    for place in (outside, home, home / "a", home / "pack", home / "dir.py"):
        place.mkdir()
    for place in (outside / "m.py", home / "m.py"):
        place.write_text(CLASS)
    (outside / "f.m").write_text("function f()\n")
    (outside / "p.sh").write_text(PROGRAM)
    (outside / "p.sh").chmod(0o755)
    (home / "a" / "b.yaml").write_text("x")
    (home / "link.py").symlink_to(outside / "m.py")
    (home / "away").symlink_to(outside)
    (home / "loop.py").symlink_to("loop.py")
    (home / "zero.py").symlink_to("/dev/zero")
    for name in ("pipe.py", "pipe.m", "pipe", "pack/pipe.py"):
        os.mkfifo(home / name)
    with socket.socket(socket.AF_UNIX) as listening:
        listening.bind(os.path.relpath(home / "socket.py"))
    return home


def world_with(use, folder, *, admit=None, **keys):
    text = json.dumps({"use": use, **keys})
    robots = "mjsim: 1\nrobots: [{name: r, preset: pioneer3dx, at: [1, 1]}]\n"
    return parse_world(
        f"{robots}run: {{drivers: {{r: {{navigator: {text}}}}}}}\n", source=Source(folder=folder, admit=admit)
    )


STRAY = {
    "absolute": "{outside}/m.py:M",
    "above": "../outside/m.py:M",
    "below and above": "a/../../outside/m.py:M",
    "link": "link.py:M",
    "link to a folder": "away/m.py:M",
    "loop of links": "loop.py:M",
    "link to a device": "zero.py:M",
    "folder": "dir.py:M",
    "pipe": "pipe.py:M",
    "socket": "socket.py:M",
    "no Python above": "../a/b.yaml:M",
    "no Python": "a/b.yaml:M",
    "the folder itself": ".:M",
    "the folder above": "..:M",
    "below a file": "m.py/m.py:M",
    "long": "a" * 240 + ".py:M",
    "long in UTF-8": "ä" * 140 + ".py:M",
    "home": "~/m.py:M",
    "function above": "../outside/f.m",
    "absolute function": "{outside}/f.m",
    "pipe of a function": "pipe.m",
    "program above": "exec:../outside/p.sh",
    "absolute program": "exec:{outside}/p.sh",
    "linked program": "exec:./away/p.sh",
    "program that is a pipe": "exec:./pipe",
    "program that is a device": "exec:/dev/zero",
}


@pytest.mark.parametrize("kind", STRAY)
def test_a_name_that_leads_elsewhere_or_to_no_file_is_refused_in_a_line_and_nothing_is_read(folder, kind):
    use = STRAY[kind].format(outside=folder.parent / "outside")
    world = world_with(use, folder)
    (problem,) = check_modules(world)
    assert "\n" not in problem.message
    assert foreign_code(world).files == {}
    assert user_files(world) == {}
    with pytest.raises(UsageError) as caught:
        make_module(Use(use=use), Source(folder=folder), role="navigator", robot="r")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("use", ["./m.py:M", "a/../m.py:M", "../home/m.py:M", "{home}/m.py:M"])
def test_other_spellings_of_a_file_beside_the_world_are_that_file(folder, use):
    world = world_with(use.format(home=folder), folder)
    assert check_modules(world) == []
    assert foreign_code(world).files == {"m.py": CLASS.encode()}
    assert make_module(Use(use=use.format(home=folder)), Source(folder=folder), role="navigator", robot="r")


IMPORTS = {
    "import link": "path 'link.py' is outside",
    "import away.m": "path 'away/m.py' is outside",
    "import pipe": "No module named 'pipe'",
    "import pack.pipe": "No module named '",
    f"import {'a' * 300}": "No module named '",
}


@pytest.mark.parametrize("line", IMPORTS)
def test_an_import_that_leads_elsewhere_or_to_no_file_ends_in_a_line_and_nothing_is_read(folder, line):
    (folder / "uses.py").write_text(f"{line}\nNAMED = 'link.py', 'away/m.py', 'pipe.py', 'zero.py'\n{CLASS}")
    world = world_with("uses.py:M", folder)
    assert list(foreign_code(world).files) == ["uses.py"]
    assert list(user_files(world)) == ["uses.py"]
    with pytest.raises(MjsimError, match=IMPORTS[line]) as caught:
        make_module(Use(use="uses.py:M"), Source(folder=folder), role="navigator", robot="r")
    assert "\n" not in str(caught.value)


def test_a_huge_file_that_code_names_is_not_read(folder):
    (folder / "huge.bin").touch()
    os.truncate(folder / "huge.bin", 1 << 40)
    (folder / "uses.py").write_text(f"NAMED = 'huge.bin'\n{CLASS}")
    world = world_with("uses.py:M", folder)
    assert list(foreign_code(world).files) == ["uses.py"]
    with pytest.raises(UsageError, match=r"the modules of 'world' have over \d+ files or \d+ MB"):
        user_files(world)


@pytest.mark.parametrize("text", ["(" * 5000, "-" * 200_000 + "1", "\0", "x = '\ud800'"])
def test_code_that_cannot_be_parsed_is_code_to_ask_about(folder, text):
    (folder / "odd.py").write_bytes(text.encode("utf-8", "surrogatepass"))
    assert list(foreign_code(world_with("odd.py:M", folder)).files) == ["odd.py"]


def test_links_between_folders_of_functions_are_followed_once(folder):
    for name in ("+a", "+b"):
        (folder / name).symlink_to(".")
    (folder / "+away").symlink_to(folder.parent / "outside")
    (folder / "go.m").write_text("function [cmd, state] = go(obs, est, robot, state)\nend\n")
    assert list(foreign_code(world_with("go.m", folder)).files) == ["go.m"]


@pytest.mark.parametrize("word", ["{outside}/m.py", "../outside/m.py", "link.py", "--config={outside}/m.py"])
def test_a_file_elsewhere_on_a_command_line_is_asked_about_with_its_content(folder, word):
    outside = folder.parent / "outside"
    world = world_with(f"exec:python3 {word.format(outside=outside)}", folder)
    code = foreign_code(world)
    assert code.files == {str(outside / "m.py"): CLASS.encode()}
    assert [use.use for use in code.installed] == [world.run.drivers["r"].navigator.use]
    (outside / "m.py").write_text("changed")
    assert foreign_code(world).files == {str(outside / "m.py"): b"changed"}
    assert user_files(world) == {}


ANSWERS = """import sys, json
for line in sys.stdin:
    print(json.dumps({"forward": VERSION} if json.loads(line)["call"] == "command" else {}), flush=True)
"""


@pytest.mark.slow
def test_of_a_file_elsewhere_the_content_that_was_allowed_runs(folder):
    program = folder.parent / "outside" / "answers.py"
    program.write_text(ANSWERS.replace("VERSION", "0.25"))
    asked = []
    world = world_with(f"exec:python3 {program}", folder, admit=lambda path, data: asked.append((path, data)))
    with mjsim.Simulation(world) as sim, closing(drivers_of(world)["r"].navigator) as navigator:
        program.write_text(ANSWERS.replace("VERSION", "0.5"))
        navigator.start(sim.robots["r"], np.random.default_rng(0))
        assert navigator.command(sim.sense("r"), Estimate(Pose(1.0, 1.0, 0.0), np.eye(3))).forward == 0.25
    assert asked == [(program, ANSWERS.replace("VERSION", "0.25").encode())]


@pytest.mark.slow
def test_a_file_elsewhere_that_appears_after_the_code_was_allowed_does_not_run(folder):
    program = folder.parent / "outside" / "later.py"
    world = world_with(f"exec:python3 {program}", folder, admit=lambda *_: None)
    with mjsim.Simulation(world) as sim, closing(drivers_of(world)["r"].navigator) as navigator:
        program.write_text(ANSWERS)
        with pytest.raises(Failed, match=r"later\.py', which did not exist when its code was allowed"):
            navigator.start(sim.robots["r"], np.random.default_rng(0))
