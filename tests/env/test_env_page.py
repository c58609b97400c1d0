"""What the page of environments says is so."""

import re
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("dm_control", reason="dm-control has releases for Python 3.11 and 3.12 only")

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "environments.md").read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_examples_of_the_page_run_and_learn_something(monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    learning, stepping, _ = re.findall("```python\n(.*?)```", PAGE.replace("seconds=8", "seconds=4"), re.DOTALL)
    names = {}
    exec(learning, names)
    assert float(capsys.readouterr().out) > 0.1
    assert names["score"](np.zeros((2, 13)), seed=1) == pytest.approx(0.0, abs=0.01)
    exec(stepping, names)
    assert names["step"].last()
    assert names["environment"].latest.time == 4.0


@pytest.mark.slow
def test_stable_baselines3_learns_as_the_page_says(monkeypatch):
    pytest.importorskip("stable_baselines3", reason="stable-baselines3 brings PyTorch; its example was tried by hand")
    monkeypatch.chdir(ROOT)
    learning, _, others = re.findall("```python\n(.*?)```", PAGE, re.DOTALL)
    names = {"__name__": "__main__"}
    quick = others.replace("20_000", "128").replace("n_steps=256", "n_steps=32")
    exec(learning.partition("env = ")[0] + quick, names)
    assert names["model"].num_timesteps == 128


def test_every_key_of_a_task_and_every_field_of_a_step_stands_on_the_page():
    from mjsim.env import Step, Task

    for kind in (Task, Step):
        for field in kind.__dataclass_fields__:
            assert re.search(rf"`(\w+\.)?{field}`", PAGE), field
