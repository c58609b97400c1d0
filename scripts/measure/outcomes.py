"""The outcomes of random faults, as a table in Markdown and in JSON."""

import json
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from faults import Fault

ROOT = Path(__file__).resolve().parents[2]


@dataclass(frozen=True, slots=True)
class Outcome:
    """The outcome of a fault."""

    fault: Fault
    caught: str | None
    """The test that failed; None where it survived."""
    slow: bool = False
    tests: int = 0
    """Number of quick tests that call the function."""

    def json(self) -> dict[str, Any]:
        """Return the outcome as JSON values."""
        path = str(self.fault.path.relative_to(ROOT))
        said = {key: getattr(self.fault, key) for key in ("line", "kind", "before", "after")}
        return {"path": path, **said, "caught": self.caught, "slow": self.slow, "tests": self.tests}


def _part(fault: Fault) -> str:
    parts = fault.path.relative_to(ROOT).parts
    return "/".join(parts[:2]) if len(parts) > 2 else parts[0]


def write_table(folder: Path, outcomes: Sequence[Outcome]) -> None:
    """Write both tables."""
    (folder / "mutants.json").write_text(json.dumps([each.json() for each in outcomes], indent=1))
    drawn, quick, every = (
        Counter(_part(each.fault) for each in outcomes if holds(each))
        for holds in (lambda _: True, lambda one: one.caught and not one.slow, lambda one: one.caught)
    )
    lines = ["| package | drawn | caught by quick tests | by all |", "|---|---|---|---|"]
    lines += [f"| {name} | {drawn[name]} | {quick[name]} | {every[name]} |" for name in sorted(drawn)]
    lines += [f"| all | {drawn.total()} | {quick.total()} | {every.total()} |", ""]
    for each in (each for each in outcomes if not each.caught or each.slow):
        fault = each.fault
        lines += [f"{fault.path.relative_to(ROOT)}:{fault.line}: {fault.kind}; {each.tests} tests; {each.caught}"]
        lines += ["```diff", f"- {fault.before}", f"+ {fault.after}", "```", ""]
    (folder / "mutants.md").write_text("\n".join(lines))
