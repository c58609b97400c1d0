"""Functions in .m files are modules: the real Octave runs them; a mistake is one line, and nothing is left running."""

import re
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import mjsim
from mjsim.cli import main
from mjsim.interface import octave_names
from mjsim.modules import check_modules, foreign_code, make_module, missing_modules, offers_in, user_files
from mjsim.web.server.answers import RefusedError
from mjsim.web.worlds.trust import Trust
from mjsim.world import Source, Use, parse_world
from tests.children import child
from tests.modules.octave_room import HEADS, ROOM, needs_octave, world_of, written
from tests.modules.processes import gone, left_running


@pytest.mark.slow
@needs_octave
def test_an_endless_loop_is_ended_after_its_patience_with_all_that_it_started(tmp_path):
    body = "system('sleep 99099 &'); while true, end"
    module = make_module(
        Use(use="mine.m", patience=0.8), _source(tmp_path, written("estimator", body)), role="estimator", robot="scout"
    )
    with mjsim.Simulation(parse_world(ROOM.replace("DRIVERS", ""))) as sim, module:
        module.take_world(sim.catalogue, None)
        module.start(sim.robots["scout"], sim.catalogue, np.random.default_rng(1))
        seen = sim.sense("scout")
        module.update(seen)
        sim.step()
        began = time.monotonic()
        with pytest.raises(Exception, match=r"did not answer within 0\.8 s and was ended"):
            module.update(replace(seen, time=1.0))
        # Half a second more at most, where no other work takes the processor; here the loop alone would go on for ever.
        assert 0.8 <= time.monotonic() - began < 30.0
    assert gone("sleep 99099")
    assert gone(str(tmp_path))


@needs_octave
@pytest.mark.slow
def test_octave_ends_with_who_started_it_even_when_that_is_killed_in_a_loop(tmp_path):
    world_of(tmp_path, "estimator: {use: mine.m, patience: 60}", written("estimator", "while true, end"))
    words = [sys.executable, "-m", "mjsim.cli", "run", str(tmp_path / "room.yaml"), "-o", str(tmp_path / "run.mcap")]
    with child(words) as parent:
        until = time.monotonic() + 60
        while not left_running(str(tmp_path / "mine.m")) and time.monotonic() < until:
            time.sleep(0.05)
        assert left_running(str(tmp_path / "mine.m"))
        time.sleep(1.0)  # it is in its loop by now, where it reads no pipe
        parent.kill()
    assert gone(str(tmp_path / "mine.m"))


def _source(folder: Path, text: str, name: str = "mine.m") -> Source:
    (folder / name).write_text(text)
    return Source(file="w", folder=folder)


EVERYTHING = """function [est, state] = mine(obs, ...  the head goes on
                              robot, state)
% MINE  Says what it was given.
if isempty(state)
    assert(isequal(size(robot.prior), [3 1]) && isequal(size(robot.prior_covariance), [3 3]))
    assert(strcmp(robot.name, 'scout') && strcmp(robot.role, 'estimator') && robot.dt == 0.04)
    assert(isequal({robot.catalogue.name}, {'lion', 'bear-2'}) && isequal(robot.catalogue(2).pose(1:2), [2; -0.5]))
    assert(strcmp(robot.sensors.x2nd_scan.name, '2nd-scan') && strcmp(robot.sensors.ring.kind, 'beacons'))
    assert(isequal(robot.sensors.ring.robot_from_sensor(4, :), [0 0 0 1]))
    assert(isequal(robot.options.gain, [1 2]) && isequal(robot.options.M, [1 2; 3 4]) && robot.options.on)
    assert(strcmp(robot.options.deep.word, 'it''s') && isequal(robot.options.mixed, {1, 'a'}))
    assert(isempty(robot.options.none))
    assert(isequal(size(robot.map.segments), [2 2 0]) && strcmp(robot.map.beacons(1).name, 'lion'))
    assert(isequal(robot.wheels, {'wheel_left', 'wheel_right'}) && isequal(size(robot.twist_from_wheels), [3 2]))
    assert(~isfield(robot.options, 'patience') && twice(21) == 42 && load('numbers.txt') == 5)
    state.count = 0;
end
state.count = state.count + 1;
assert(abs(obs.time - 0.04 * (state.count - 1)) < 1e-9)
assert(isequal(size(obs.z), [2 2]) && isequal(sort(obs.id), [1 2]) && isequal(size(obs.R), [2 2 2]))
at = robot.catalogue(obs.id(1)).pose(1:2);
assert(abs(obs.z(1, 1) - norm(at)) < 1 && abs(obs.z(2, 1) - atan2(at(2), at(1))) < 0.5)
assert(isequal(size(obs.odometry.covariance), [3 3]) && isequal(size(obs.proximity), [1 16]) && isempty(obs.bump))
if isfield(obs.scans, 'x2nd_scan')
    assert(isequal(size(obs.scans.x2nd_scan.ranges), [1 8]) && strcmp(obs.scans.x2nd_scan.name, '2nd-scan'))
    assert(all(isinf(obs.scans.x2nd_scan.ranges)) && issorted(obs.scans.x2nd_scan.angles))
end
est.pose = [state.count; randn; rand];
est.covariance = eye(3);
est.landmarks = [1 2 3; 4 5 6];
est.landmark_covariance = repmat(0.01 * eye(2), [1 1 3]);
est.ids = [2 0 77];
est.innovations = [0.1; 0.2];
est.innovation_covariance = eye(2);
est.innovation_ids = 1;
est.show = {struct('points', [1 2; 3 4], 'name', 'cloud'), struct('lines', [0 0]), ...
            struct('grid', [0 1; NaN 1], 'resolution', 0.5), struct('text', 'hi', 'at', [1 2])};
end
"""
LOOKER = """function [cmd, state] = looker(obs, est, robot, state)
assert(isequal(est.landmarks, [1 2 3; 4 5 6]) && isequal(est.ids, [2 0 77]) && isequal(size(est.pose), [3 1]))
assert(isequal(size(est.landmark_covariance), [2 2 3]))
cmd.forward = 0.2; cmd.turn = 0.1; cmd.messages = {struct('a', [1 2]), 'hi'};
cmd.show = struct('lines', [0 0; 1 2], 'name', 'way');
end
"""


@pytest.mark.slow
@needs_octave
def test_a_function_gets_what_the_docs_say_and_its_answer_arrives_whole(tmp_path):
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib" / "twice.m").write_text("function y = twice(x)\ny = 2 * x;\nend\n")
    (tmp_path / "numbers.txt").write_text("5\n")
    (tmp_path / "looker.m").write_text(LOOKER)
    keys = 'gain: [1, 2], M: [[1, 2], [3, 4]], on: true, deep: {word: "it\'s"}, mixed: [1, a], none: null, paths: [lib]'
    world = world_of(tmp_path, f"estimator: {{use: mine.m, {keys}}}, navigator: {{use: looker.m}}", EVERYTHING)
    assert check_modules(world) == []
    assert sorted(user_files(world)) == ["lib/twice.m", "looker.m", "mine.m", "numbers.txt"]
    with mjsim.Simulation(world) as sim:
        recording = mjsim.run(sim)
    track = recording.robots["scout"]
    np.testing.assert_array_equal(track.estimate[:, 0], np.arange(1, 16))
    assert len(np.unique(track.estimate[:, 1])) == 15
    assert track.landmarks.names == ("bear-2", 2, 77)
    np.testing.assert_array_equal(track.landmarks.mean[-1], [[1, 4], [2, 5], [3, 6]])
    np.testing.assert_array_equal(track.landmarks.covariance[-1], [0.01 * np.eye(2)] * 3)
    ((name, nu, S),) = track.innovations[-1]
    assert (name, nu.tolist(), S.tolist()) == ("lion", [0.1, 0.2], np.eye(2).tolist())
    assert track.command[-1].tolist()[:3:2] == [0.2, 0.1]
    cloud, line, grid, text, way = track.shown[-1]
    assert (way.name, way.points.tolist()) == ("way", [[0, 0, 0], [1, 2, 0]])
    assert (cloud.name, cloud.points.tolist()) == ("cloud", [[1, 2, 0], [3, 4, 0]])
    assert (line.points.tolist(), text.text, text.at.tolist()) == ([[0, 0, 0]], "hi", [1, 2, 0])
    np.testing.assert_array_equal(grid.cells, [[0, 1], [np.nan, 1]])


REACH = """function [cmd, state] = reach(obs, est, robot, state)
assert(strcmp(robot.arms.my_arm.name, 'my-arm') && numel(robot.arms.my_arm.joints) == 6)
assert(isequal(size(obs.joints.my_arm.q), [6 1]) && isequal(size(obs.joints.my_arm.tau), [6 1]))
arm = robot.arms.my_arm;
q = 0.1 * (1:6);
assert(norm(fkine(arm, q) - FKINE) < 1e-12 && norm(jacob0(arm, q) - JACOBIAN) < 1e-12)
assert(norm(rne(arm, q, q, 2 * q) - RNE) < 1e-10 && norm(gravload(arm, q) - GRAVLOAD) < 1e-10)
assert(norm(inertia(arm, q) - INERTIA) < 1e-10 && norm(fkine(arm, ikine(arm, FKINE, q + 0.1)) - FKINE) < 1e-9)
cmd.joints.my_arm.q = 0.1 * ones(1, 6);
end
"""


def reach() -> str:
    """Return the navigator, with the numbers that the functions for arms must give it."""
    arm, q = mjsim.arm("puma560"), 0.1 * np.arange(1, 7)
    numbers = {
        "FKINE": arm.fkine(q),
        "JACOBIAN": arm.jacob0(q),
        "RNE": arm.rne(q, q, 2 * q),
        "GRAVLOAD": arm.gravload(q),
        "INERTIA": arm.inertia(q),
    }
    text = REACH
    for key, value in numbers.items():
        rows = np.atleast_2d(value).tolist()
        text = text.replace(key, "[" + "; ".join(" ".join(map(repr, row)) for row in rows) + "]")
    return text


SPRING = """function [tau, state] = spring(fast, wanted, robot, state)
assert(strcmp(robot.part, 'my-arm') && fast.dt == 0.004 && isempty(fast.imu))
goal = zeros(6, 1);
if isfield(wanted.joints, 'my_arm')
    goal = wanted.joints.my_arm.q;
end
tau = 500 * (goal - fast.joints.my_arm.q) - 60 * fast.joints.my_arm.qd;
end
"""


@pytest.mark.slow
@needs_octave
def test_functions_move_arms(tmp_path):
    (tmp_path / "reach.m").write_text(reach())
    (tmp_path / "spring.m").write_text(SPRING)
    (tmp_path / "arm.yaml").write_text(
        "robots: [{name: r, base: fixed, at: [1, 2], arms: [{name: my-arm, preset: puma560}]}]\n"
        "run: {drivers: {r: {navigator: {use: reach.m}, controllers: {my-arm: {use: spring.m}}}}}\n"
    )
    world = mjsim.load_world(tmp_path / "arm.yaml")
    assert check_modules(world) == []
    with mjsim.Simulation(world) as sim:
        mjsim.run(sim, seconds=0.6)
        reached = sim.sense("r").joints["my-arm"].positions
    assert np.all(reached > 0.0)  # a spring without gravity compensation moves towards its goal
    assert gone(str(tmp_path))
    (tmp_path / "spring.m").write_text(SPRING.replace("tau = 500", "tau = [1 2]; % 500"))
    with mjsim.Simulation(world) as sim, pytest.raises(mjsim.ModuleFault) as caught:
        mjsim.run(sim, seconds=0.6)
    assert re.match(
        r"controller spring\.m of robot 'r' at 0\.0\d s returned 2 torques; .*\(spring\.m:1\)", str(caught.value)
    )
    assert gone(str(tmp_path))


@needs_octave
@pytest.mark.slow
def test_the_same_seed_gives_the_same_bytes_in_runs_and_replays(tmp_path):
    (tmp_path / "numbers.txt").write_text("5\n")
    noisy = written("estimator", "").replace(
        "robot.prior;", "robot.prior + [rand; randn; rande] * 0.01 + randperm(3)';"
    )
    world = world_of(tmp_path, "estimator: {use: mine.m}", noisy)
    runs = []
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        with mjsim.Simulation(world, seed=seed) as sim:
            runs.append(mjsim.run(sim, record=tmp_path / f"{name}.mcap").robots["scout"].estimate)
    assert runs[0].tobytes() == runs[1].tobytes()
    assert runs[0].tobytes() != runs[2].tobytes()
    spec, again = f"{tmp_path}/mine.m{{patience: 5}}", tmp_path / "again.mcap"
    words = ["replay", str(tmp_path / "a.mcap"), "--robot", "scout", "--estimator", spec, "-o", str(again)]
    with pytest.raises(SystemExit) as left:
        main(words)
    assert left.value.code == 0
    assert mjsim.read_recording(again).robots["scout"].estimate.tobytes() == runs[0].tobytes()


@needs_octave
@pytest.mark.slow
def test_a_sweep_has_one_octave_a_worker_and_a_session_one_of_its_own(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib" / "twice.m").write_text("function y = twice(x)\ny = 2 * x;\nend\n")
    noisy = written("estimator", "").replace("robot.prior;", "robot.prior + 0.01 * [rand; randn; twice(rand)];")
    world = world_of(tmp_path, "estimator: {use: mine.m, paths: [lib]}", noisy)
    with pytest.raises(SystemExit) as left:
        main(["sweep", "room.yaml", "--seeds", "1:3", "-o", "out", "--workers", "1", "--keep"])
    assert left.value.code == 0, capsys.readouterr().err
    with mjsim.Session(world, seed=2, record=tmp_path / "live.mcap") as session:
        session.result()
    live = mjsim.read_recording(tmp_path / "live.mcap").robots["scout"].estimate
    (kept,) = Path("out/runs").glob("*seed0002.mcap")
    np.testing.assert_array_equal(mjsim.read_recording(kept).robots["scout"].estimate, live)
    assert gone(str(tmp_path))


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (f"% help first\n\nfunction {HEADS['estimator']}\nend\n", None),
        ("%{\nfunction not(this)\n%}\nfunction [est, state] = other(a, ...\n b, c) % why\n", None),
        ("function varargout = mine(varargin)\n", None),
        ("function [est,state]=mine(obs,robot,state,more)\n", None),
        ("x = 1;\n", "mine.m:1: does not begin with a function; a script cannot be a module"),
        ("% nothing\n", "mine.m holds no function"),
        (
            "\nfunction [est, state] = mine(obs, state)\n",
            "mine.m:2: mine takes 2 arguments (obs, state);"
            " an estimator is: function [est, state] = mine(obs, robot, state)",
        ),
        (
            "function est = mine(obs, robot, state)\n",
            "mine.m:1: mine returns 1 value (est); an estimator is: function [est, state] = mine(obs, robot, state)",
        ),
        (
            "function mine\n",
            "mine.m:1: mine takes 0 arguments; an estimator is: function [est, state] = mine(obs, robot, state)",
        ),
    ],
)
def test_check_looks_into_the_file_without_running_it(tmp_path, text, line):
    world = world_of(tmp_path, "\n    estimator: {use: mine.m}", text)
    said = [str(problem).partition("room.yaml:")[2] for problem in check_modules(world)]
    assert said == ([] if line is None else [f"13:22: {line}"])
    assert missing_modules(world) == []


@pytest.mark.parametrize(
    ("module", "line"),
    [
        ("use: my.m", "no file 'my.m' beside the world file; did you mean 'mine.m'?"),
        ("use: ../mine.m", "path '../mine.m' is outside the folder of the world; keep it beside the world file"),
        ("use: 2nd.m", "'2nd' cannot be the name of a function; a name has letters, digits and '_'"),
        ("use: mine.m, patience: soon", "patience is 'soon'; it must be a time above 0 [s]"),
        ("use: mine.m, paths: [../other]", "path '../other' is outside the folder of the world;"),
    ],
)
def test_what_is_not_there_is_the_worlds_mistake(tmp_path, module, line):
    (tmp_path / "2nd.m").write_text("")
    world = world_of(tmp_path, f"estimator: {{{module}}}", written("estimator", ""))
    (problem,) = missing_modules(world)
    assert line in str(problem)


def test_without_octave_one_line_says_what_to_install(tmp_path, capsys, monkeypatch):
    world_of(tmp_path, "estimator: {use: mine.m}", written("estimator", ""))
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(SystemExit) as left:
        main(["run", str(tmp_path / "room.yaml"), "-o", str(tmp_path / "run.mcap")])
    assert left.value.code == 2
    assert capsys.readouterr().err == (
        "modules in .m files need GNU Octave; type: sudo apt-get install --no-install-recommends octave\n"
    )


def test_names_of_the_world_become_fields_and_those_that_meet_are_refused():
    assert octave_names(["front cam", "2nd", "a.b-c", "plain_1"]) == {
        "front cam": "front_cam",
        "2nd": "x2nd",
        "a.b-c": "a_b_c",
        "plain_1": "plain_1",
    }
    with pytest.raises(ValueError, match="'a-b' and 'a_b' both become the field 'a_b'; rename one"):
        octave_names(["a-b", "a_b"])


def test_the_studio_lists_functions_by_their_heads_and_asks_before_they_run(tmp_path):
    (tmp_path / "private").mkdir()
    (tmp_path / "private" / "inner.m").write_text("function y = inner(x)\ny = x;\n")
    (tmp_path / "other.m").write_text("x = 1;\n")
    world = world_of(tmp_path, "estimator: {use: mine.m}", written("estimator", ""))
    files = [(path, path.name) for path in sorted(tmp_path.glob("*.m"))]
    assert [(offer.role, offer.use, offer.about) for offer in offers_in(files)] == [
        ("estimator", "mine.m", "MINE  A test.")
    ]
    assert sorted(foreign_code(world).files) == ["mine.m", "other.m", "private/inner.m"]


@pytest.mark.slow
@needs_octave
def test_where_code_must_be_allowed_a_copy_of_what_was_allowed_runs(tmp_path):
    source = _source(tmp_path, written("navigator", "").replace("0.1", "0.3"))
    allowed = (tmp_path / "mine.m").read_bytes()

    def admit(path, data):
        if data != allowed:
            raise mjsim.UsageError(f"{path.name} has changed")

    use, source = Use(use="mine.m"), Source(file="w", folder=tmp_path, admit=admit)
    module = make_module(use, source, role="navigator", robot="scout")
    (tmp_path / "mine.m").write_text("function mine\nerror('something else')\n")  # after the look, before the start
    with mjsim.Simulation(parse_world(ROOM.replace("DRIVERS", ""))) as sim:
        track = mjsim.run(sim, drivers={"scout": mjsim.Driver(navigator=module)}).robots["scout"]
    assert track.command[-1, 0] == 0.3
    with pytest.raises(mjsim.UsageError, match=r"mine\.m has changed"):
        make_module(use, source, role="navigator", robot="scout")


@pytest.mark.slow
@needs_octave
def test_what_a_function_prints_is_shown_with_its_robot_within_bounds(tmp_path, capfd):
    text = written("estimator", "disp([1 22; 3 4]); for k = 1:500, fprintf('%d\\n', k); end").replace("> 0.18", "== 0")
    with mjsim.Simulation(world_of(tmp_path, "estimator: {use: mine.m}", text)) as sim:
        mjsim.run(sim)
    shown = [line for line in capfd.readouterr().err.splitlines() if line.startswith("scout/estimator: ")]
    assert shown[:2] == ["scout/estimator:     1   22", "scout/estimator:     3    4"]
    assert len(shown) == 201


@needs_octave
def test_the_studio_runs_a_function_only_as_it_was_when_somebody_was_asked(tmp_path):
    world = world_of(tmp_path, "navigator: {use: mine.m}", written("navigator", ""))
    trust = Trust()
    asked = trust.asks_for(world)
    assert sorted(asked) == ["mine.m"]
    with pytest.raises(RefusedError, match=r"not allowed yet, or that has changed: mine\.m"):
        trust.check(world)
    trust.allow(world, asked)
    guarded = trust.guarded(world.source)
    use = world.run.drivers["scout"].navigator
    assert make_module(use, guarded, role="navigator", robot="scout").name == "mine.m"
    (tmp_path / "mine.m").write_text(written("navigator", "system('true');"))
    with pytest.raises(mjsim.UsageError, match=r"'mine\.m' is code that you have not allowed in its present form"):
        make_module(use, guarded, role="navigator", robot="scout")
    assert sorted(trust.asks_for(world)) == ["mine.m"]
