"""Springs too stiff for what they move are told before a run, and only those."""

import pytest

import mjsim
from mjsim.world import check_world, parse_world

WORLD = """
mjsim: 1
mechanisms:
  - name: m
    at: [0, 0]
    elevation: 3
    bodies: [{name: a, box: [0.1, 0.1, 0.1], mass: MASS}, {name: b, sphere: 0.05, mass: MASS}]
    joints:
      - {prismatic: x, of: [ground, a], axis: [0, 0, 1], JOINT}
      - {six_dof: f, of: [ground, b], start: [1, 0, -2]}
    constraints: [{spring: [a, b], SPRING}]
run: {step_ms: STEP}
"""
SOFT = "stiffness: 1"


def told(mass: float, joint: str, spring: str, step: int) -> tuple[str, str]:
    """Return what check says of a world, and the end of the error with which the physics of its first 0.2 s fails."""
    text = WORLD.replace("MASS", str(mass)).replace("JOINT", joint).replace("SPRING", spring)
    world = parse_world(text.replace("STEP", str(step)))
    said = " ".join(problem.message for problem in check_world(world))
    try:
        with mjsim.Simulation(world) as sim:
            mjsim.run(sim, seconds=0.2)
    except mjsim.PhysicsFault as fault:
        return said, str(fault).partition("likely cause: ")[2]
    return said, ""


@pytest.mark.filterwarnings("ignore:overflow encountered")
@pytest.mark.parametrize(
    ("mass", "joint", "spring", "step", "says"),
    [
        (1e-6, SOFT, "damping: 1", 4, "it moves in steps of 4 ms, and the physics would fail; make it softer"),
        (1e-3, SOFT, "stiffness: 100, damping: 1", 4, "spring 'constraint1' is too stiff"),
        (1e-3, "stiffness: 400", SOFT, 4, "would fail; use run: {step_ms: 2}, or make it softer"),
        (1e-3, "stiffness: 400", SOFT, 2, ""),
        (1e-3, "stiffness: 200", SOFT, 4, ""),
        (1e-3, f"{SOFT}, damping: 100", SOFT, 4, ""),  # the damping of joints is implicit
        (1.0, "stiffness: 1.0e+5", "stiffness: 1.0e+4, damping: 100", 4, ""),
    ],
)
def test_springs_too_stiff_for_the_step_are_told_with_a_remedy(mass, joint, spring, step, says):
    said, fails = told(mass, joint, spring, step)
    assert says in said
    assert fails == said
    assert bool(said) == bool(says)
