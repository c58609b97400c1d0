"""The state of a run whose ticks come from a program of the user, as browsers are told it."""

from mjsim.run import ticks
from mjsim.sim import Simulation
from mjsim.web.run.current_run import Stage
from mjsim.world import parse_world


def test_a_run_without_a_session_is_idle_then_loads_runs_and_ends():
    world, stage = parse_world("mjsim: 1\nrobots: [{name: r, at: [0, 0]}]\n"), Stage(lambda world: {})
    states = [stage.run_json()["state"]]
    stage.put_on(world, None)
    states.append(stage.run_json()["state"])
    with Simulation(world) as sim:
        tick = next(iter(ticks(sim, {})))
    stage.take(tick)
    states.append(stage.run_json()["state"])
    stage.close()
    states.append(stage.run_json()["state"])
    assert states == ["idle", "loading", "running", "ended"]
