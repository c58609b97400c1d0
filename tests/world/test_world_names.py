"""Shipped worlds by name, `mjsim worlds`, and what every command line has: version, short help, completion."""

import os
import sys
import tomllib
from pathlib import Path

import pytest

import mjsim
from mjsim.cli import main
from mjsim.cli.studio_command import opened
from mjsim.world import shipped_worlds, world_path
from tests.children import completed

ROOT = Path(__file__).parents[2]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """A working folder in which a folder is called as a shipped world."""
    monkeypatch.chdir(tmp_path)
    Path("gallery").mkdir()
    return tmp_path


def typed(*words, capsys):
    """Run the command line in this process; return exit code, stdout and stderr."""
    with pytest.raises(SystemExit) as ended:
        main(words)
    out, err = capsys.readouterr()
    return ended.value.code, out, err


def test_the_version_is_that_of_the_project(capsys):
    version = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
    assert typed("--version", capsys=capsys) == (0, f"mjsim {version}\n", "")


@pytest.mark.parametrize("command", [(), ("run",), ("studio",), ("worlds",)])
def test_h_prints_the_help_everywhere(command, capsys):
    code, out, _ = typed(*command, "-h", capsys=capsys)
    assert code == 0
    assert (code, out) == typed(*command, "--help", capsys=capsys)[:2]
    assert out.startswith("Usage: mjsim")


def test_a_bare_word_names_a_shipped_world_even_beside_a_folder_of_that_name():
    assert mjsim.load_world("gallery").name == "gallery"
    assert mjsim.load_world(Path("gallery")) == mjsim.load_world(ROOT / "worlds" / "gallery.yaml")


@pytest.mark.parametrize("place", ["./gallery", "gallery/", "gallery.yaml", "rooms/gallery"])
def test_what_has_a_folder_or_an_ending_is_a_path(place):
    assert world_path(place) == Path(place)


@pytest.mark.slow
def test_every_command_that_takes_a_world_takes_a_name(capsys):
    for words in (
        ("check", "gallery", "empty"),
        ("fmt", "--check", "gallery"),
        ("compile", "empty", "-o", "scene"),
        ("show", "empty", "-o", "plan.png"),
        ("export-world", "empty", "--svg", "empty.svg"),
        ("run", "empty", "--seconds", "0.2", "-o", "empty.mcap"),
    ):
        assert typed(*words, capsys=capsys)[0] == 0, words


def test_the_studio_opens_a_shipped_world_in_the_working_folder(folder):
    assert opened("gallery") == (folder, "shipped:gallery")
    assert opened("husky") == (folder, "shipped:robots/husky")
    Path("rooms").mkdir()
    assert opened("rooms") == (Path("rooms"), None)
    assert opened("gallery/") == opened("./gallery") == (Path("gallery"), None)
    with pytest.raises(mjsim.UsageError, match="did you mean 'husky'"):
        opened("huskie")


def test_a_misspelt_name_gets_a_suggestion(capsys):
    expected = "no shipped world 'galery'; did you mean 'gallery'?\n"
    for command in (["check"], ["run"], ["show", "-o", "a.png"], ["sweep", "--seeds", "1", "-o", "s"], ["fmt"]):
        assert typed(*command, "galery", capsys=capsys) == (2, "", expected), command


def test_a_folder_with_its_path_is_no_shipped_world(capsys):
    code, _, err = typed("check", "./gallery", capsys=capsys)
    assert (code, err) == (2, "gallery:1:1: this is a folder; name a world file\n")


def test_a_file_that_is_named_without_its_ending_is_told_with_it(capsys):
    Path("room.yaml").write_text("mjsim: 1\n")
    code, _, err = typed("check", "room", capsys=capsys)
    assert (code, err) == (2, "no shipped world 'room'; to name the file here, type 'room.yaml'\n")


def test_worlds_lists_each_world_with_its_file_and_one_line(capsys):
    code, out, _ = typed("worlds", capsys=capsys)
    lines = out.splitlines()
    assert code == 0
    assert {line.split()[0] for line in lines} == {path.stem for path in (ROOT / "worlds").rglob("*.yaml")}
    for line in lines:
        name, rest = line.split(maxsplit=1)
        path = str(shipped_worlds()[name])
        assert rest.startswith(f"{path} ")
        assert rest.removeprefix(path).strip().endswith(".")


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(shipped_worlds()))
def test_a_copy_of_any_shipped_world_is_the_same_world(name, capsys):
    assert typed("worlds", "--copy", name, capsys=capsys) == (0, f"{name}.yaml\n", "")
    assert mjsim.load_world(f"{name}.yaml") == mjsim.load_world(name)
    assert "yaml-language-server" not in Path(f"{name}.yaml").read_text()


def test_a_copy_overwrites_only_when_asked(capsys):
    Path("mine.yaml").write_text("work of a day")
    words = ("worlds", "--copy", "empty", "-o", "mine.yaml")
    code, _, err = typed(*words, capsys=capsys)
    assert (code, err) == (2, "'mine.yaml' exists; name another file, or add --overwrite (in Python: overwrite=True)\n")
    assert Path("mine.yaml").read_text() == "work of a day"
    assert typed(*words, "--overwrite", capsys=capsys)[0] == 0
    assert mjsim.load_world("mine.yaml").name == "empty"


def offered(line: str) -> list[str]:
    """Return what bash offers at the end of a line, as the script of `--show-completion` asks for it."""
    words = line.split(" ")
    environment = {"_MJSIM_COMPLETE": "complete_bash", "COMP_WORDS": line, "COMP_CWORD": str(len(words) - 1)}
    command = [sys.executable, "-m", "mjsim.cli"]
    done = completed(command, check=False, env=os.environ | environment)
    return done.stdout.split()


@pytest.mark.slow
def test_a_shell_completes_commands_options_and_worlds(folder):
    Path("my-room.yaml").touch()
    assert offered("mjsim ex") == ["export", "export-world", "experiments"]
    assert offered("mjsim run --rea") == ["--realtime"]
    assert offered("mjsim run ga") == ["gallery", "gallery/"]
    assert offered("mjsim check my") == ["my-room.yaml"]
    Path("rooms").mkdir()
    Path("rooms/garden.yaml").touch()
    assert offered(f"mjsim check {folder}/rooms/ga") == [f"{folder}/rooms/garden.yaml"]


@pytest.mark.slow
@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_script_for_each_shell_is_printed(shell):
    command = [sys.executable, "-m", "mjsim.cli", "--show-completion"]
    environment = os.environ | {"_TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION": "1"}
    done = completed([*command, shell], env=environment)
    assert "_MJSIM_COMPLETE" in done.stdout


@pytest.mark.parametrize(
    ("name", "meant"), [("plaster", "materials/plaster.jpg"), ("lion.png", "posters/lion.jpg"), ("nosuch", None)]
)
def test_a_shipped_file_without_its_folder_is_suggested_with_it(name, meant):
    with pytest.raises(mjsim.WorldError) as caught:
        mjsim.parse_world(f"mjsim: 1\nfloor: {{texture: {name}}}\n")
    assert str(caught.value).endswith(f"did you mean '{meant}'?" if meant else "in assets")
