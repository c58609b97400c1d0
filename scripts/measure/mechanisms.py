"""Print by how much mechanisms miss closed forms at steps of 1, 2 and 4 ms, beside what is asked, and the order.

python scripts/measure/mechanisms.py [NAME]...   (all unless some are named)
"""

import math
import sys

from mjsim.bench.closed_forms import FORMS, Form

STEPS = (1, 2, 4)
"""[ms]"""
NOISE = 1e-11
"""Errors below this are rounding, and have no order."""


def row(name: str, form: Form) -> str:
    """Return the line of a closed form in the table."""
    errors = [form.error(step) for step in STEPS]
    orders = [math.log2(errors[k + 1] / errors[k]) for k in (0, 1) if errors[k] > NOISE]
    order = f"{min(orders):.2f}" if orders and form.has_order else "-"
    asked = [f"{value:.2g}" if value == value else "-" for value in form.asked]
    shown = [f"{errors[k]:.2g}" for k in (0, 2)]
    return f"| {name} [{form.unit}] | {shown[0]} | {asked[0]} | {shown[1]} | {asked[1]} | {order} |"


def main() -> None:
    """Print the table."""
    print("| error of | 1 ms | asked | 4 ms | asked | order |\n|---|---|---|---|---|---|")
    for name in sys.argv[1:] or FORMS:
        print(row(name, FORMS[name]), flush=True)


if __name__ == "__main__":
    main()
