"""A navigator says why its robot does not get on."""

import pytest

import mjsim
from mjsim.report import write_report

ROOM = """
mjsim: 1
robots: [{name: scout, preset: create3, at: [1, 1]}]
"""


class Waits:
    """Blocked from 0.2 to 0.4 s and from 0.6 s on."""

    def start(self, robot, map, rng):
        self.time = 0.0

    def command(self, seen, belief):
        self.time = seen.time
        return mjsim.Command()

    def blocked(self):
        return "a cupboard is in the way" if 0.19 < self.time < 0.41 or self.time > 0.59 else None


def run(navigator, record=None):
    with mjsim.Simulation(mjsim.parse_world(ROOM)) as sim:
        return mjsim.run(sim, drivers={"scout": mjsim.Driver(navigator=navigator)}, seconds=1.0, record=record)


EVENT = ("blocked", "scout is blocked: a cupboard is in the way")


def test_each_time_that_it_begins_to_is_one_event():
    events = run(Waits()).robots["scout"].events
    assert [(event.kind, event.text) for event in events] == [EVENT] * 2
    assert [event.time for event in events] == pytest.approx([0.2, 0.6], abs=0.021)


@pytest.mark.slow
def test_the_recording_and_the_report_keep_the_reasons(tmp_path):
    recording = run(Waits(), tmp_path / "run.mcap")
    write_report(recording, tmp_path / "report")
    page = next((tmp_path / "report").glob("*.html")).read_text("utf-8")
    assert page.count(EVENT[1]) == 2


def test_a_reason_that_is_no_text_is_a_fault_of_the_module():
    class Wrong(Waits):
        def blocked(self):
            return 3

    with pytest.raises(mjsim.ModuleFault, match="it must be None or 1 to 200 printable characters"):
        run(Wrong())
