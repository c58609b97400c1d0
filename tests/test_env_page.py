"""What the page of environments says is so."""

import re
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("dm_control", reason="dm-control has releases for Python 3.11 and 3.12 only")

ROOT = Path(__file__).parent.parent
PAGE = (ROOT / "docs" / "environments.md").read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_examples_of_the_page_run_and_learn_something(monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    learning, stepping = re.findall("```python\n(.*?)```", PAGE, re.DOTALL)
    names = {}
    exec(learning, names)
    assert float(capsys.readouterr().out) > 0.1
    assert names["score"](np.zeros((2, 13)), seed=1) == pytest.approx(0.0, abs=0.01)
    exec(stepping, names)
    assert names["step"].last()
    assert names["environment"].latest.time == 8.0


def test_every_key_of_a_task_and_every_field_of_a_step_stands_on_the_page():
    from mjsim.env import Step, Task

    for kind in (Task, Step):
        for field in kind.__dataclass_fields__:
            assert re.search(rf"`(\w+\.)?{field}`", PAGE), field
