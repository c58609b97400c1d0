"""What the page of sensors says is so."""

import re
from pathlib import Path

import mjsim
from mjsim.world import check_world

ROOT = Path(__file__).parents[2]


def test_the_example_of_the_page_of_sensors_runs_as_it_says(capsys):
    page = (ROOT / "docs" / "sensors.md").read_text(encoding="utf-8")
    (text,), (code, _) = (re.findall(f"```{kind}\n(.*?)```", page, re.DOTALL) for kind in ("yaml", "python"))
    world = mjsim.parse_world(text)
    assert check_world(world) == []
    exec(code, {"world": world})
    first, sightings, felt, heard = capsys.readouterr().out.splitlines()
    assert abs(float(first.split()[0]) - 3.96) < 0.1
    assert "lion" in sightings
    assert felt.startswith("5 [")
    assert heard == "[{'seen': 'lion'}]"


def test_every_key_of_every_sensor_stands_in_the_world_with_all_of_them_or_on_the_page():
    from mjsim.world.items.sensing.sensors import SENSOR_KINDS

    told = (ROOT / "docs" / "sensors.md").read_text(encoding="utf-8") + (ROOT / "worlds" / "sensors.yaml").read_text()
    for model in SENSOR_KINDS.values():
        for key in model.model_fields:
            assert re.search(rf"\b{key}\b", told), key
