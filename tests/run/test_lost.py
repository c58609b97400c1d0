"""An estimator says when its robot is lost: one event where that begins, one where it ends."""

import pytest

import mjsim
from mjsim.report import write_report
from tests.run.test_blocked import ROOM


class Doubts:
    """Lost from 0.2 to 0.4 s and from 0.6 s on."""

    answer = True

    def start(self, robot, catalogue, rng):
        self.pose, self.time = robot.prior, 0.0

    def update(self, seen):
        self.time = seen.time
        return mjsim.Estimate(self.pose, [[1, 0, 0], [0, 1, 0], [0, 0, 1]])

    def lost(self):
        return self.answer if 0.19 < self.time < 0.41 or self.time > 0.59 else False


class Sure(Doubts):
    answer = False


def run(estimator, record=None):
    with mjsim.Simulation(mjsim.parse_world(ROOM)) as sim:
        return mjsim.run(sim, drivers={"scout": mjsim.Driver(estimator=estimator)}, seconds=1.0, record=record)


def events(recording):
    return [(event.kind, round(event.time, 1)) for event in recording.robots["scout"].events]


TOLD = [("lost", 0.2), ("found", 0.4), ("lost", 0.6)]


def test_each_beginning_and_each_end_is_an_event():
    assert events(run(Doubts())) == TOLD
    assert events(run(Sure())) == []


@pytest.mark.slow
def test_the_report_keeps_them_and_a_replay_has_those_of_its_own_estimator(tmp_path):
    recording = run(Doubts(), tmp_path / "run.mcap")
    write_report(recording, tmp_path / "report")
    page = next((tmp_path / "report").glob("*.html")).read_text("utf-8")
    assert page.count("scout is lost: what it senses does not fit its estimate") == 2
    sure = mjsim.replay(recording, robot="scout", estimator=Sure(), record=tmp_path / "sure.mcap")
    assert events(sure) == []
    again = mjsim.replay(sure, robot="scout", estimator=Doubts(), record=tmp_path / "again.mcap")
    assert events(again) == TOLD


def test_an_answer_that_is_neither_is_a_fault_of_the_module():
    class Wrong(Doubts):
        answer = "perhaps"

    with pytest.raises(mjsim.ModuleFault, match="it must be True or False"):
        run(Wrong())
