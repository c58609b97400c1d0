"""The directive `command-line`: one section for each command of mjsim with its help, from the parser."""

from docutils import nodes
from docutils.parsers.rst import Directive
from sphinx.application import Sphinx
from typer.testing import CliRunner

from mjsim.cli.program import COMMANDS, app


class CommandLine(Directive):
    """Sections in the order of `mjsim --help`."""

    def run(self) -> list[nodes.Node]:
        """Return a section for each command."""
        return [self._section(name) for name in COMMANDS]

    def _section(self, name: str) -> nodes.section:
        section = nodes.section(ids=[name], names=[name])
        section += nodes.title(text=f"mjsim {name}")
        shown = CliRunner().invoke(app([name]), [name, "--help"], prog_name="mjsim", terminal_width=100)
        section += nodes.literal_block(text=shown.stdout.strip(), language="text")
        self.state.document.note_explicit_target(section)
        return section


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directive."""
    app.add_directive("command-line", CommandLine)
    return {"parallel_read_safe": True}
