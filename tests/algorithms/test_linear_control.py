"""What the laboratory designs drives the plants of its lesson."""

import numpy as np
import pytest

import mjsim
from mjsim.algorithms.linear_control import SpeedLoop, StateFeedback, TransferLaw


def run(name: str, seconds: float) -> mjsim.Recording:
    with mjsim.Simulation(mjsim.load_world(name)) as sim:
        return mjsim.run(sim, seconds=seconds)


def test_a_transfer_function_answers_a_step_as_its_formula_says():
    law = TransferLaw([2.0], [1.0, 4.0])
    found = [law.output(1.0, 0.001) for _ in range(1000)]
    times = (np.arange(1000) + 0.5) * 0.001
    np.testing.assert_allclose(found, 0.5 * (1 - np.exp(-4 * times)), atol=1e-4)


@pytest.mark.slow
def test_a_placed_feedback_holds_the_balancing_robot_under_a_swinging_push():
    lean = _lean(run("lab-7-place", 8.0))
    assert np.abs(lean).max() < np.radians(15)
    assert np.abs(lean[75:100]).max() < np.radians(1.0)


def test_the_speed_loop_follows_its_reference():
    track = run("lab-4-speed", 2.0).robots["scout"]
    speed = np.gradient(track.truth[:, 0], track.time)
    assert speed[-15:-2].mean() == pytest.approx(0.3, abs=0.02)


@pytest.mark.slow
def test_the_joint_loop_brings_a_joint_to_its_goal():
    track = run("lab-5-joint", 3.0).joints["puma/arm"]
    assert np.degrees(track.positions[20, 2]) == pytest.approx(20.0, abs=0.5)
    assert np.degrees(track.positions[-1, 2]) == pytest.approx(35.0, abs=1.0)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: TransferLaw([1, 2, 3], [1, 2]), "num must not have a higher degree than den"),
        (lambda: TransferLaw([1], [0]), "neither may be 0"),
        (lambda: StateFeedback([1, 2]), "give four finite numbers, for distance, lean, and their rates"),
        (lambda: SpeedLoop(num=[1], den=[1], reference={"step": {}}), "to is missing"),
    ],
)
def test_a_wrong_law_is_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def _lean(recording: mjsim.Recording) -> np.ndarray:
    """Return the pitch of the balancing robot over time [rad]."""
    x, y, z, w = recording.robots["joe"].truth_pose[:, 3:].T
    return np.arcsin(np.clip(2 * (w * y - z * x), -1.0, 1.0))
