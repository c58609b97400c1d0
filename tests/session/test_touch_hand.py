"""Hands of people led while a world runs: refused in a line where they cannot be, and repeated once written down."""

import pytest

import mjsim
from mjsim.errors import UsageError
from mjsim.record import same_run
from mjsim.session import keep_events
from mjsim.world import ReachEvent, ReleaseEvent

PATIENCE = 60.0
"""Nothing takes this long [s], on however loaded a machine."""
ROOM = """
mjsim: 1
people:
  - {name: anna, sex: female, at: [1.5, 0], heading_deg: 180}
robots:
  - {name: r, at: [0, 0], sensors: [{lidar: scan, at: [0, 0, 1], beams: 61, fov_deg: 60, range: [0.05, 5]}]}
run: {seconds: 2}
"""


@pytest.mark.slow
def test_what_hands_did_by_hand_repeats_to_the_byte_once_it_is_kept(tmp_path):
    hand, kept = tmp_path / "hand.mcap", tmp_path / "kept.mcap"
    with mjsim.Session(mjsim.parse_world(ROOM), record=hand) as session:
        session.pause()
        session.wait("paused", timeout=PATIENCE)
        session.touch({"reach": "anna", "hand": "right", "to": [1.1, 0.1, 1.0]})
        session.tick()
        session.wait("paused", timeout=PATIENCE)
        assert session.reach("anna", "left", [1.1, -0.2, 1.2]) == 0.0
        for wrong, said in [("ana", "no person 'ana' in this world; did you mean 'anna'?"), ("r", "no person 'r'")]:
            with pytest.raises(UsageError, match=said):
                session.touch({"reach": wrong, "hand": "left", "to": [1, 0, 1]})
        for _ in range(10):
            session.tick()
            session.wait("paused", timeout=PATIENCE)
        short = session.reach("anna", "left", [-1, 0, 1.2])
        assert 1.0 < short < 2.5
        session.tick()
        session.wait("paused", timeout=PATIENCE)
        assert session.reach("anna", "right", None) == 0.0
        with pytest.raises(UsageError, match="no person 'ana'"):
            session.reach("ana", "left", None)
        session.go()
        session.result()
        events = session.touched
    assert [event.hand for event in events] == ["right", "left", "left", "right"]
    world = mjsim.parse_world(keep_events(ROOM, events))
    with mjsim.Simulation(world) as sim:
        mjsim.run(sim, record=kept)
    assert same_run(hand, kept)
    # A recording tells what happened, exactly, and how far a hand stayed away.
    told = mjsim.read_recording(hand).events
    assert [(event.hand, event.to, event.short) for event in told if isinstance(event, ReachEvent)] == [
        ("right", (1.1, 0.1, 1.0), 0.0),
        ("left", (1.1, -0.2, 1.2), 0.0),
        ("left", (-1.0, 0.0, 1.2), short),
    ]
    assert [event.hand for event in told if isinstance(event, ReleaseEvent)] == ["right"]
