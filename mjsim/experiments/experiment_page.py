"""The page of the classic experiments: verdicts, findings and plots, in files that open offline."""

import json
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain
from pathlib import Path
from typing import Any

from mjsim.experiments.finding import Finding, Plot, Result
from mjsim.output import write_files
from mjsim.report import Block, Heading, HtmlPicture, HtmlTable, Paragraph, html_page

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
    """Return the findings of experiments as lines for a terminal."""
    rows = []
    for result in results:
        rows.append(f"{result.title}: {verdict(result.holds)}")
        rows += [f"  {f.what:<56}{number(f):>9}  {f.wanted:<14}{verdict(f.holds)}" for f in result.findings]
    return rows


def verdict(holds: bool) -> str:
    """Return the verdict as a word."""
    return "holds" if holds else "does not hold"


def number(finding: Finding) -> str:
    """Return the value of a finding with a reasonable number of digits."""
    return f"{finding.value:.0f}" if finding.value == round(finding.value) else f"{finding.value:.3g}"


def _json(results: Sequence[Result]) -> str:
    shown = {
        result.name: {
            "holds": result.holds,
            "title": result.title,
            "question": result.question,
            "pictures": {picture.name: picture.caption for picture in result.pictures},
            "findings": [
                {"what": f.what, "value": f.value, "wanted": f.wanted, "holds": f.holds} for f in result.findings
            ],
        }
        for result in results
    }
    return json.dumps(shown, indent=1) + "\n"


def finished(folder: Path) -> dict[str, Result] | None:
    """Return the results on the page of a folder by name, with their plots; None if it has no such page."""
    try:
        shown = json.loads((folder / "results.json").read_text())
        return {name: _result(folder / name, name, each) for name, each in shown.items()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None


def _result(folder: Path, name: str, shown: Mapping[str, Any]) -> Result:
    pictures = tuple(
        Plot(name=each, caption=caption, png=(folder / f"{each}.png").read_bytes())
        for each, caption in shown["pictures"].items()
    )
    findings = tuple(Finding(**each) for each in shown["findings"])
    title, question = shown["title"], shown["question"]
    return Result(name=name, title=title, question=question, findings=findings, pictures=pictures)


def _page(results: Sequence[Result]) -> str:
    blocks = chain.from_iterable(map(_blocks, results))
    return html_page("The classic experiments", "mjsim", *blocks, style=MORE)


def _blocks(result: Result) -> Iterator[Block]:
    rows = [(f.what, number(f), f.wanted, (verdict(f.holds), "holds" if f.holds else "fails")) for f in result.findings]
    yield Heading(result.title)
    yield Paragraph(result.question)
    yield HtmlTable(("", "measured", "required", ""), rows)
    for each in result.pictures:
        yield HtmlPicture(each.caption, f"{result.name}/{each.name}.png", captioned=True)
