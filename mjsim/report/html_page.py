"""Common parts of all result pages, from reports to workplaces: HTML that works offline, light and dark."""

import base64
import html
from collections.abc import Iterable, Sequence

STYLE = """
:root { color-scheme: light dark; --ink: #1c1c1c; --paper: #fdfdfb; --soft: #6b6b6b; --line: #ddddd8;
  --bad: #a5201a; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e8e8e4; --paper: #1b1c1e; --soft: #a5a5a0; --line: #3a3b3e; --bad: #ff9d94; }
}
body { font: 16px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--paper); max-width: 60rem;
  margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.6rem; margin-bottom: 0; } h2 { font-size: 1.2rem; margin-top: 2.5rem; }
.wide { overflow-x: auto; } .wide td { white-space: nowrap; }
p.fault { color: var(--bad); }
p.run { color: var(--soft); margin-top: 0.2rem; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th, td { text-align: right; padding: 0.3rem 0.6rem; border-bottom: 1px solid var(--line); }
th:first-child, td:first-child { text-align: left; }
thead th { color: var(--soft); font-weight: 500; }
img { width: 100%; height: auto; margin: 1rem 0; background: #fff; border-radius: 6px; }
"""


def html_page(title: str, command: str, *parts: str, style: str = "") -> str:
    """Return a complete page.

    Args:
        title: Its heading, as text.
        command: The command that wrote it, such as 'mjsim report', as text.
        parts: Its contents below the heading, as HTML.
        style: CSS rules beyond those of all pages.
    """
    heading = html.escape(title)
    return (
        f'<!doctype html><html lang="en"><meta charset="utf-8"><title>{heading} - {html.escape(command)}</title>'
        f'<meta name="viewport" content="width=device-width"><style>{STYLE}{style}</style>'
        f"<main><h1>{heading}</h1>{''.join(parts)}</main></html>\n"
    )


def html_table(
    heads: Sequence[str], rows: Iterable[Sequence[str]], *, kind: str | None = None, wide: bool = False
) -> str:
    """Return a table.

    Args:
        heads: Headers of its columns, as text; '' for a column without header, and none at all for no header row.
        rows: Its cells, as text.
        kind: Its class.
        wide: Whether its lines are not wrapped and it scrolls, also with keys, if it is wider than the page.
    """
    above = f"<thead>{_row(heads, 'th')}</thead>" if heads else ""
    opened = f'<table class="{kind}">' if kind else "<table>"
    table = f"{opened}{above}<tbody>{''.join(_row(row, 'td') for row in rows)}</tbody></table>"
    return f'<div class="wide" tabindex="0">{table}</div>' if wide else table


def _row(cells: Sequence[str], tag: str) -> str:
    # A header cell without text tells users of screen readers nothing: it is a plain cell.
    marked = (("td" if not cell else tag, html.escape(cell)) for cell in cells)
    return f"<tr>{''.join(f'<{name}>{cell}</{name}>' for name, cell in marked)}</tr>"


def picture(title: str, png: bytes) -> str:
    """Return a picture embedded in its page."""
    return f'<img alt="{html.escape(title)}" src="data:image/png;base64,{base64.b64encode(png).decode()}">'
