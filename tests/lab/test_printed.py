"""What `mjsim lab` prints of a plant."""

from mjsim.cli import laboratory

PLANT = {
    "input": "force",
    "outputs": ["x", "angle"],
    "states": ["x", "v"],
    "poles": [[-1.0, 2.0], [-1.0, -2.0]],
    "zeros": [],
    "dry_friction": 0.25,
    "identification": {"source": "run.mcap", "poles": [[-3.0, 0.0]], "identified_fit_percent": [98.765, 1.0]},
    "designs": [
        {"name": "pid", "poles": [[-1.0, 0.0]], "stable": True},
        {"name": "lqr", "poles": [[0.0, 0.0]], "stable": False},
    ],
}


def test_a_plant_is_told_with_its_poles_its_friction_and_its_designs():
    lines = laboratory._lines("cart", PLANT)
    assert lines[0] == "cart: force -> x, angle; states x, v"
    assert lines[1].startswith("  poles -1")
    assert lines[1].endswith("; zeros none")
    assert lines[2] == "  dry friction of up to 0.25 is left out of both; the page also shows it"
    assert lines[3] == "  identified from run.mcap: poles -3; fit 98.77 %, 1.00 %"
    assert lines[4:] == ["  pid: closed-loop poles -1", "  lqr: closed-loop poles 0; not stable"]
    plain = {key: value for key, value in PLANT.items() if key not in ("dry_friction", "identification")}
    assert laboratory._lines("cart", {**plain, "designs": []}) == lines[:2]
