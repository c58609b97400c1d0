"""The help of the command line can be read on a terminal of 80 columns."""

import pytest

from mjsim.cli.program import COMMANDS
from tests.cli.shell import typed


def test_no_description_in_the_list_of_commands_is_cut(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    code, out, err = typed("--help", capsys=capsys)
    lines = out.partition("Commands:\n")[2].splitlines()
    assert (code, err) == (0, "")
    assert [line.split()[0] for line in lines] == list(COMMANDS)
    assert not [line for line in lines if not line.endswith(".") or line.endswith("...")]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("run", "room.yaml"), "mjsim: interrupted; anything recorded so far is closed and readable\n"),
        (
            ("sweep", "room.yaml", "--seeds", "0:2", "-o", "out"),
            "mjsim: interrupted; the same command continues the sweep\n",
        ),
        (("check", "room.yaml"), "mjsim: interrupted\n"),
        (("lab", "room.yaml"), "mjsim: interrupted\n"),
    ],
)
def test_an_interrupted_command_says_what_is_left(words, said, capsys, monkeypatch):
    def interrupt(*_args, **_keys):
        raise KeyboardInterrupt

    monkeypatch.setattr("mjsim.cli.program.app", lambda _names: interrupt)
    assert typed(*words, capsys=capsys) == (130, "", said)
