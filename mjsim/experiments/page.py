"""The page of the classic experiments: verdicts, figures and plots, in files that open offline."""

import html
import json
from collections.abc import Sequence
from pathlib import Path

from mjsim.experiments.finding import Finding, Result
from mjsim.output import write_files
from mjsim.report import html_page

MORE = """
.holds { color: #1a7f37; } .fails { color: #c62828; }
@media (prefers-color-scheme: dark) { .holds { color: #57c46f; } .fails { color: #ff8a80; } }
td:last-child, th:last-child { text-align: left; } figcaption { color: var(--soft); } figure { margin: 1.5rem 0; }
"""

FILES = ("index.html", "results.json")
"""Files of the page, beside the folder of each experiment."""


def write_page(folder: Path, results: Sequence[Result], *, overwrite: bool = False) -> None:
    """Write `index.html`, `results.json`, and the plots of each experiment into its folder.

    Raises:
        UsageError: A file exists, or cannot be written.
    """
    files = {"index.html": _page(results).encode(), "results.json": _json(results).encode()}
    for result in results:
        files |= {f"{result.name}/{picture.name}.png": picture.png for picture in result.pictures}
    write_files(folder, files, overwrite=overwrite)


def lines(results: Sequence[Result]) -> list[str]:
    """Return the figures of experiments as lines for a terminal."""
    rows = []
    for result in results:
        rows.append(f"{result.title}: {verdict(result.holds)}")
        rows += [f"  {f.what:<56}{number(f):>9}  {f.wanted:<14}{verdict(f.holds)}" for f in result.findings]
    return rows


def verdict(holds: bool) -> str:
    """Return the verdict as a word."""
    return "holds" if holds else "does not hold"


def number(finding: Finding) -> str:
    """Return the value of a figure with a reasonable number of digits."""
    return f"{finding.value:.0f}" if finding.value == round(finding.value) else f"{finding.value:.3g}"


def _json(results: Sequence[Result]) -> str:
    shown = {
        result.name: {
            "holds": result.holds,
            "findings": [
                {"what": f.what, "value": f.value, "wanted": f.wanted, "holds": f.holds} for f in result.findings
            ],
        }
        for result in results
    }
    return json.dumps(shown, indent=1) + "\n"


def _page(results: Sequence[Result]) -> str:
    return html_page("The classic experiments", "mjsim", *map(_section, results), style=MORE)


def _section(result: Result) -> str:
    rows = "".join(
        f"<tr><td>{html.escape(f.what)}</td><td>{number(f)}</td><td>{html.escape(f.wanted)}</td>"
        f'<td class="{"holds" if f.holds else "fails"}">{verdict(f.holds)}</td></tr>'
        for f in result.findings
    )
    figures = "".join(
        f'<figure><img alt="{html.escape(p.caption)}" src="{result.name}/{p.name}.png">'
        f"<figcaption>{html.escape(p.caption)}</figcaption></figure>"
        for p in result.pictures
    )
    return (
        f"<h2>{html.escape(result.title)}</h2><p>{html.escape(result.question)}</p>"
        "<table><thead><tr><td></td><th>measured</th><th>required</th><td></td></tr></thead>"
        f"<tbody>{rows}</tbody></table>{figures}"
    )
