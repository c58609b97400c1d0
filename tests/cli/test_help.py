"""The help of the command line can be read on a terminal of 80 columns."""

from mjsim.cli.program import COMMANDS
from tests.cli.shell import typed


def test_no_description_in_the_list_of_commands_is_cut(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    code, out, err = typed("--help", capsys=capsys)
    lines = out.partition("Commands:\n")[2].splitlines()
    assert (code, err) == (0, "")
    assert [line.split()[0] for line in lines] == list(COMMANDS)
    assert not [line for line in lines if not line.endswith(".") or line.endswith("...")]
