"""A mobile manipulator drives to a table by its own map, knows the parcel by its picture, and lifts it by contact."""

import numpy as np
import pytest

import mjsim
from mjsim.world import parse_world, worlds_folder

START = "at: [2.9, 2.35]\n    heading_deg: -5"
"""Nearer than in the world as it is shipped, to be short; so are fewer pictures."""
TABLE = 0.5
"""Height of its top [m]."""


def shipped():
    return mjsim.load_world("manipulator")


@pytest.mark.slow
def test_the_parcel_is_more_than_5_cm_above_the_table_at_the_end():
    text = (worlds_folder() / "manipulator.yaml").read_text()
    moved = text.replace("at: [1.2, 1.0]\n    heading_deg: 20", START).replace("rate_hz: 5", "rate_hz: 2.5")
    assert START in moved
    world = parse_world(moved, source=shipped().source)
    heights, held = [], []
    with mjsim.Simulation(world, seed=2) as sim:
        parcel = sim.model.body("obstacle/parcel").id

        def look(tick):
            heights.append(sim.data.xpos[parcel, 2])
            pairs = sim.model.geom_bodyid[sim.data.contact.geom]
            touching = set(pairs[(pairs == parcel).any(axis=1)].ravel().tolist()) - {parcel}
            held.append({sim.model.body(body).name for body in touching})

        mjsim.run(sim, seconds=28.0, watch=look)
    assert heights[0] == pytest.approx(TABLE, abs=1e-3)
    assert min(heights[-25:]) > TABLE + 0.05
    # Nothing but the fingers touches it at the end, and it was never pushed off the table before.
    assert held[-1] == {"fetcher/arm/link5", "fetcher/arm/link6"}
    assert min(heights) > TABLE - 0.01


@pytest.mark.slow
def test_what_cannot_be_picked_up_is_told():
    from mjsim.algorithms.pick import PickUp

    with pytest.raises(ValueError, match="force is -1; it must be above 0"):
        PickUp("p", box=(0.1, 0.1, 0.1), width=0.1, force=-1)
    with mjsim.Simulation(shipped()) as sim:
        info = sim.robots["fetcher"]
        for options, sentence in (({"arm": "leg"}, "no arm 'leg'"), ({"camera": "rear"}, "no camera 'rear'")):
            with pytest.raises(ValueError, match=sentence):
                PickUp("p", box=(0.1, 0.1, 0.1), width=0.1, **options).start(info, None, np.random.default_rng(0))
