"""Write the tables of docs/people.md: measures, joints and segments, with the source of each number.

python scripts/make/people_page.py
"""

import math
from pathlib import Path

from mjsim.people import OUTSIDE, SEXES, Figure, Measures, Sex, survey

PAGE = Path(__file__).resolve().parents[2] / "docs" / "people.md"
SHOWN: tuple[tuple[Sex, int], ...] = (("female", 5), ("female", 50), ("male", 50), ("male", 95))
"""Figures of the table of measures: sex and percentile of stature."""


def page(text: str) -> str:
    """Return the page with its tables as they are now."""
    for name, table in (("measures", measures()), ("joints", joints()), ("masses", masses())):
        begin, end = f"<!-- {name}: begin -->\n", f"<!-- {name}: end -->"
        before, _, rest = text.partition(begin)
        text = f"{before}{begin}\n{table}\n{end}{rest.partition(end)[2]}"
    return text


def measures() -> str:
    """Return the table of measures."""
    bodies = [Measures.at_percentile(sex, percentile) for sex, percentile in SHOWN]
    heads = " | ".join(f"{sex}, p{percentile}" for sex, percentile in SHOWN)
    rows = [f"| measure | {heads} |", "|---|" + "---|" * len(SHOWN)]
    for name in survey("female").names:
        digits = 1 if name == "weight" else 4 if name == "interpupillary_breadth" else 3
        mark = " (not kept)" if name in OUTSIDE else ""
        rows.append(f"| `{name}`{mark} | " + " | ".join(f"{body[name]:.{digits}f}" for body in bodies) + " |")
    return "\n".join(rows) + "\n"


def joints() -> str:
    """Return the table of joints, those of a side once."""
    rows = ["| joint | moves | range [degrees] | source |", "|---|---|---|---|"]
    for joint in Figure.of(Measures.at_percentile("male")).joints.values():
        if joint.name.startswith("right_"):
            continue
        name, segment = (word.replace("left_", "SIDE_") for word in (joint.name, joint.segment))
        low, high = (round(math.degrees(each)) for each in (joint.low, joint.high))
        rows.append(f"| `{name}` | `{segment}` | {low} to {high} | {joint.source} |")
    return "\n".join(rows) + "\n"


def masses() -> str:
    """Return the table of segments: masses of a woman and of a man at percentile 50."""
    figures = [Figure.of(Measures.at_percentile(sex)) for sex in SEXES]
    rows = ["| segment | parent | " + " | ".join(f"{sex}, p50 [kg]" for sex in SEXES) + " |", "|---|---|---|---|"]
    for name, segment in figures[0].segments.items():
        if not name.startswith("right_"):
            shown, parent = (word.replace("left_", "SIDE_") for word in (name, segment.parent or ""))
            weights = " | ".join(f"{figure.segments[name].solid.mass:.2f}" for figure in figures)
            rows.append(f"| `{shown}` | {parent and f'`{parent}`'} | {weights} |")
    return "\n".join(rows) + "\n"


if __name__ == "__main__":
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
