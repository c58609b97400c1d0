"""Programs in any language are modules: JSON lines, one line for each mistake, and nothing left running."""

import json
import os
import re
import runpy
import shutil
from pathlib import Path

import jsonschema
import numpy as np
import pytest

import mjsim
from mjsim.cli import main
from mjsim.modules import check_modules, foreign_code, make_module, user_files
from mjsim.world import Source, Use, parse_world, with_settings
from tests.children import completed
from tests.modules.processes import gone
from tests.python_script import HEAD

PROGRAMS = Path(__file__).parents[1] / "data" / "programs"
MAKER = runpy.run_path(str(Path(__file__).parents[2] / "scripts" / "make" / "programs.py"))
SCHEMA = json.loads((Path(__file__).parents[2] / "docs" / "programs.schema.json").read_text())
ROOM = """
mjsim: 1
name: room
beacons: [{name: lion, at: [2, 0.5]}, {name: bear-2, at: [2, -0.5]}]
walls: [{points: [[-1, -3], [4, -3], [4, 3], [-1, 3]], closed: true}]
robots:
  - name: scout
    at: [0, 0]
    sensors:
      - {beacons: ring, range: [0.2, 8], fov_deg: 360, rate_hz: 25}
      - {lidar: scan, at: [0, 0, 0.35], beams: 8, fov_deg: 360, rate_hz: 12.5}
run: {seconds: 1.0, map: known, drivers: {scout: {DRIVERS}}}
"""


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    """The program in C."""
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        pytest.skip("no C compiler here; type: sudo apt-get install gcc")
    path = tmp_path_factory.mktemp("c") / "reckon"
    completed([compiler, "-O2", "-o", path, PROGRAMS / "reckon.c", "-lm"])
    return path


def room(folder: Path, drivers: str) -> mjsim.World:
    """Return a world of a folder whose robot has these modules."""
    (folder / "room.yaml").write_text(ROOM.replace("DRIVERS", drivers))
    return mjsim.load_world(folder / "room.yaml")


def script(folder: Path, name: str, text: str, *, head: str = HEAD) -> None:
    """Write a program."""
    (folder / name).write_text(head + text)
    (folder / name).chmod(0o755)


@pytest.mark.slow
def test_the_schema_has_the_readings_as_they_are_declared():
    text = MAKER["FILE"].read_text(encoding="utf-8")
    assert MAKER["with_readings"](text) == text


def test_a_c_program_and_a_shell_script_drive_a_robot_and_leave_nothing_running(tmp_path, compiled):
    shutil.copy(compiled, tmp_path)
    shutil.copy(PROGRAMS / "ahead.sh", tmp_path)
    world = room(
        tmp_path,
        f"estimator: {{use: 'exec:./reckon 1.0 {tmp_path}'}}, navigator: {{use: 'exec:./ahead.sh {tmp_path}'}}",
    )
    assert check_modules(world) == []
    with mjsim.Simulation(with_settings(world, ["robots.scout.at=[2.2, 0]"])) as sim:
        track = mjsim.run(sim, seconds=6.0).robots["scout"]
    np.testing.assert_allclose(track.estimate, track.odometry, atol=1e-9)  # the loop's own dead reckoning
    np.testing.assert_allclose(track.covariance, track.odometry_covariance, atol=1e-12)
    assert 3.0 < track.truth[-1, 0] < 3.7  # it went to the wall at 4 m, and turned there
    assert np.abs(track.truth[:, 2]).max() > 0.3
    assert gone(str(tmp_path))


@pytest.mark.slow
def test_a_c_program_estimates_in_a_sweep(tmp_path, compiled, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    shutil.copy(compiled, tmp_path)
    room(
        tmp_path, "estimator: {use: 'exec:./reckon 1.0'}, navigator: {use: 'mjsim.algorithms.constant:ConstantCommand'}"
    )
    with pytest.raises(SystemExit) as left:
        main(["sweep", "room.yaml", "--seeds", "0:3", "-o", "out", "--workers", "1"])
    assert left.value.code == 0, capsys.readouterr().err
    outcomes = [json.loads(path.read_text()) for path in sorted(Path("out/runs").glob("*.json"))]
    assert [outcome["error"] for outcome in outcomes] == [None] * 3
    for outcome in outcomes:
        figures = outcome["robots"]["scout"]
        assert figures["position_error_m"]["rmse"] == pytest.approx(figures["odometry_error_m"]["rmse"], abs=1e-9)
    assert gone(str(tmp_path))


REPLY = """
import json, os, subprocess, sys, time
for line in sys.stdin:
    asked = json.loads(line)
    if asked["call"] == "start":
        print("{}", flush=True)
        continue
    if asked["obs"]["time"] < 0.18:
        print(json.dumps(GOOD), flush=True)
        continue
    BAD
"""
GOOD = {"pose": [0, 0, 0], "covariance": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}
MISTAKES = [
    # What a program does at 0.20 s, and what the line says after that.
    ("sys.exit('no map here')", "ended with exit code 1 before it answered: no map here"),
    ("os.kill(os.getpid(), 9)", "was ended by SIGKILL before it answered"),
    ("1 / 0", "ended with exit code 1 before it answered: ZeroDivisionError: division by zero"),
    ("os.close(1); sys.exit(2)", "ended with exit code 2 before it answered"),
    ("print('hello', flush=True)", "answered 'hello', which is not JSON; print other output to standard error"),
    ("print(json.dumps(GOOD, indent=1), flush=True)", "answered '{', which is not JSON; write each answer on one line"),
    ("print('[1, 2]', flush=True)", "answered JSON that is not an object; write {...}"),
    ("print(json.dumps({'error': 'lost\\nat sea'}), flush=True)", "raised lost at sea"),
    ("print('{}', flush=True)", "returned no est.pose"),
    ("print(json.dumps({**GOOD, 'pose': [1, 2, None]}), flush=True)", "returned a pose that is not finite"),
    (
        "print(json.dumps({**GOOD, 'show': [{'lines': [[0, False], [1, 1]], 'joined': True}]}), flush=True)",
        "answered with lines that holds true or false; write numbers",
    ),
    (
        "print(json.dumps({'pose': [0, 0, 0], 'covarience': [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}), flush=True)",
        "answered with the key 'covarience'; did you mean 'covariance'?",
    ),
    ("while True: pass", "did not answer within 1 s and was ended"),
    ("subprocess.run(['sleep', '77077'])", "did not answer within 1 s and was ended"),
]


@pytest.mark.slow
@pytest.mark.parametrize(("bad", "says"), MISTAKES)
def test_a_mistake_is_one_line_and_what_was_recorded_is_readable(tmp_path, bad, says):
    script(tmp_path, "bad", REPLY.replace("GOOD", repr(GOOD)).replace("BAD", bad.replace("GOOD", repr(GOOD))))
    # Whatever does answer, or end, may take as long as a busy machine needs for it.
    patience = 1 if says.startswith("did not answer") else 30
    world = room(tmp_path, f"estimator: {{use: 'exec:./bad {tmp_path}', patience: {patience}}}")
    with mjsim.Simulation(world) as sim, pytest.raises(mjsim.ModuleFault) as caught:
        mjsim.run(sim, record=tmp_path / "run.mcap")
    assert str(caught.value).startswith(f"estimator bad of robot 'scout' at 0.20 s {says}")
    assert len(mjsim.read_recording(tmp_path / "run.mcap").time) == 5
    assert gone(str(tmp_path))
    assert gone("sleep 77077")


def test_two_answers_to_one_request_are_an_error(tmp_path):
    script(
        tmp_path,
        "bad",
        REPLY.replace("GOOD", repr(GOOD)).replace("BAD", f"print({json.dumps(GOOD)!r} + chr(10) + '{{}}', flush=True)"),
    )
    world = room(tmp_path, "estimator: {use: 'exec:./bad'}")
    with mjsim.Simulation(world) as sim, pytest.raises(mjsim.ModuleFault, match=r"answered more than it was asked for"):
        mjsim.run(sim)


def test_a_second_answer_that_comes_late_is_told(tmp_path, capfd):
    script(
        tmp_path, "twice", REPLY.replace("GOOD", repr(GOOD)).replace("BAD", f"print({json.dumps(GOOD)!r}, flush=True)")
    )
    text = (tmp_path / "twice").read_text() + "print('{}', flush=True)\n"  # after the end of the requests
    (tmp_path / "twice").write_text(text)
    world = room(tmp_path, "estimator: {use: 'exec:./twice'}")
    with mjsim.Simulation(world) as sim:
        mjsim.run(sim, seconds=0.2)
    assert "scout/estimator: gave more answers than it was asked for" in capfd.readouterr().err


@pytest.mark.parametrize(
    ("name", "first", "says"),
    [
        ("mine", "#!/no/such/python", "the interpreter '/no/such/python' in its first line, which does not exist"),
        ("mine", "#!", "names the interpreter '' in its first line, which does not exist; correct the line"),
        (
            "mine",
            "#!/bin/sh\r",
            "has Windows line endings, so its first line starts no interpreter; save it with those of Linux",
        ),
        ("mine", "#!/usr/bin/env -S nosuchtongue -u", "needs the interpreter 'nosuchtongue', which is not installed"),
        ("mine.py", "import sys", "does not name its interpreter; begin it with '#!/usr/bin/env python3', or write"),
        ("mine.sh", "read line", ""),
        ("mine", "#!/usr/bin/env -S LANG=C sh -e", ""),
        ("mine.py", "\x7fELF\0", ""),
    ],
)
def test_a_script_whose_first_line_starts_nothing_is_told_before_it_is_run(tmp_path, name, first, says):
    script(tmp_path, name, f"{first}\n", head="")
    said = " ".join(str(problem) for problem in check_modules(room(tmp_path, f"navigator: {{use: 'exec:./{name}'}}")))
    assert says in said
    assert bool(says) == bool(said)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read every file")
def test_a_program_that_may_be_run_but_not_read_is_no_defect(tmp_path):
    script(tmp_path, "mine", "#!/no/such/python\n", head="")
    (tmp_path / "mine").chmod(0o111)
    assert list(check_modules(room(tmp_path, "navigator: {use: 'exec:./mine'}"))) == []


@pytest.mark.parametrize(
    ("module", "line"),
    [
        ("use: 'exec:./absent'", "8: no file './absent' beside the world file; there are ahead.sh, plain, room.yaml"),
        ("use: 'exec:./plain'", "8: './plain' cannot be executed; type: chmod +x plain"),
        ("use: 'exec:../up'", "8: path '../up' is outside the folder of the world; keep it beside the world file"),
        ("use: 'exec:/bin/sh'", "8: path '/bin/sh' is outside the folder of the world; keep it beside the world file"),
        ("use: 'exec:nosuchprogram x'", "8: no program 'nosuchprogram' is installed; one beside the world file is"),
        ("use: 'exec:./ahead.sh', patience: -1", "33: patience is -1; it must be a time above 0 [s]"),
        ("use: 'exec:./ahead.sh', paths: ['../x']", "33: path '../x' is outside the folder of the world;"),
        ("use: 'exec:./ahead.sh', paths: [lib]", "33: no folder 'lib' beside the world file"),
    ],
)
def test_check_looks_for_a_program_without_running_it(tmp_path, module, line):
    shutil.copy(PROGRAMS / "ahead.sh", tmp_path)
    (tmp_path / "plain").write_text("#!/bin/sh\n")
    world = room(tmp_path, f"\n    navigator: {{{module}}}")
    (problem,) = check_modules(world)
    assert re.match(rf".*room\.yaml:13:\d+: {re.escape(line.partition(': ')[2])}", str(problem)), problem


def test_trust_and_sweeps_name_the_program_its_arguments_and_its_paths(tmp_path):
    shutil.copy(PROGRAMS / "ahead.sh", tmp_path)
    (tmp_path / "slam.jl").write_text("x")
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib" / "more").write_text("y")
    drivers = "estimator: {use: 'exec:cat slam.jl', paths: [lib]}, navigator: {use: 'exec:./ahead.sh -q'}"
    world = parse_world(ROOM.replace("DRIVERS", drivers), source=Source(file="w", folder=tmp_path))
    code = foreign_code(world)
    assert sorted(code.files) == ["ahead.sh", "lib/more", "slam.jl"]
    assert [use.use for use in code.installed] == ["exec:cat slam.jl"]
    assert sorted(user_files(world)) == ["ahead.sh", "lib/more", "slam.jl"]


def test_where_code_must_be_allowed_a_copy_of_what_was_allowed_runs(tmp_path):
    shutil.copy(PROGRAMS / "ahead.sh", tmp_path)
    allowed = (tmp_path / "ahead.sh").read_bytes()

    def admit(path, data):
        if data != allowed:
            raise mjsim.UsageError(f"{path.name} has changed")

    use, source = Use(use="exec:./ahead.sh"), Source(file="w", folder=tmp_path, admit=admit)
    module = make_module(use, source, role="navigator", robot="scout")
    script(tmp_path, "ahead.sh", "raise SystemExit('something else')\n")  # after the look, before the start
    with mjsim.Simulation(parse_world(ROOM.replace("DRIVERS", ""))) as sim:
        track = mjsim.run(sim, drivers={"scout": mjsim.Driver(navigator=module)}, seconds=0.4).robots["scout"]
    assert track.command[-1, 0] == 0.3
    with pytest.raises(mjsim.UsageError, match=r"ahead\.sh has changed"):
        make_module(use, source, role="navigator", robot="scout")


ECHO = """
import json, os, sys
log = open("told.jsonl", "a")
for line in sys.stdin:
    log.write(line)
    asked = json.loads(line)
    answer = {
        "start": {"pictures": True},
        "observe": {"id": [2, 0], "range": [1.5, 2.5], "bearing": [0.1, -0.1], "R": [[[0.01, 0], [0, 0.01]]] * 2},
        "update": GOOD | {"landmarks": [[1, 2]], "landmark_covariance": [[[1, 0], [0, 1]]], "ids": [2]},
        "command": {"forward": 0.2, "messages": ["hi", {"a": [1]}]},
        "adjust": {"forward": 0.1},
        "torques": {"tau": [0.0]},
    }[asked["call"]]
    log.write(json.dumps({asked["call"]: answer}) + "\\n")
    log.flush()
    print(json.dumps(answer), flush=True)
"""


@pytest.mark.slow
@pytest.mark.parametrize("camera", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_every_message_follows_the_schema_of_the_docs(tmp_path, camera):
    script(tmp_path, "echo", ECHO.replace("GOOD", repr(GOOD)))
    more = "      - {imu: imu, rate_hz: 50}\n"
    more += "      - {camera: eye, at: [0.1, 0, 0.3], width: 32, height: 24, rate_hz: 12.5}\n" if camera else ""
    roles = ("observer", "estimator", "navigator", "avoidance")
    text = ROOM.replace("run:", f"{more}run:").replace(
        "DRIVERS", ", ".join(f"{role}: {{use: 'exec:./echo', gain: [1, 2]}}" for role in roles)
    )
    (tmp_path / "room.yaml").write_text(text)
    with mjsim.Simulation(mjsim.load_world(tmp_path / "room.yaml")) as sim:
        recording = mjsim.run(sim, seconds=0.4)
    lines = [json.loads(line) for line in (tmp_path / "told.jsonl").read_text().splitlines()]
    requests = [line for line in lines if "call" in line]
    answers = [line for line in lines if "call" not in line]
    assert {line["call"] for line in requests} == {"start", "observe", "update", "command", "adjust"}
    asks = jsonschema.Draft202012Validator(SCHEMA)
    answering = jsonschema.Draft202012Validator({"$defs": SCHEMA["$defs"], "$ref": "#/$defs/answers"})
    for line in requests:
        asks.validate(line)
    for line in answers:
        answering.validate(line)
    broken = {**requests[-1], "extra": 1}
    with pytest.raises(jsonschema.ValidationError):
        asks.validate(broken)
    shapes = [each["image"]["shape"] for line in requests for each in line.get("obs", {}).get("cameras", {}).values()]
    assert shapes == [[24, 32, 3]] * (5 * len(roles) if camera else 0)
    track = recording.robots["scout"]
    assert [seen.name for seen in track.sightings[-1]][-2:] == ["bear-2", None]
    assert track.command[-1, 0] == pytest.approx(0.1)
    est = next(line["est"] for line in requests if line["call"] == "command")
    assert est["landmarks"] == [[1.0, 2.0]]
    assert est["ids"] == [2.0]


ARM = """
mjsim: 1
robots: [{name: r, base: fixed, at: [1, 2], arms: [{name: my-arm, preset: puma560}]}]
run: {seconds: 0.2, drivers: {r: {navigator: {use: 'exec:./echo'}, controllers: {my-arm: {use: 'exec:./echo'}}}}}
"""


@pytest.mark.slow
def test_programs_move_arms_as_the_schema_says(tmp_path):
    script(
        tmp_path,
        "echo",
        ECHO.replace("GOOD", repr(GOOD))
        .replace('"forward": 0.2, ', '"joints": {"my-arm": {"q": [0.1] * 6, "qd": [0.2] * 6}}, ')
        .replace('"tau": [0.0]', '"tau": [0.5] * 6'),
    )
    (tmp_path / "room.yaml").write_text(
        ARM.replace("NAVIGATOR", "'exec:./echo'").replace("CONTROLLER", "'exec:./echo'")
    )
    world = mjsim.load_world(tmp_path / "room.yaml")
    assert check_modules(world) == []
    with mjsim.Simulation(world) as sim:
        mjsim.run(sim)
    lines = [json.loads(line) for line in (tmp_path / "told.jsonl").read_text().splitlines()]
    asks = jsonschema.Draft202012Validator(SCHEMA)
    for line in lines:
        if "call" in line:
            asks.validate(line)
    fast = [line for line in lines if line.get("call") == "torques"]
    assert len(fast) == 40  # at 250 Hz, between the first and the last of five ticks
    assert fast[-1]["fast"]["joints"]["my-arm"]["tau"] == pytest.approx([0.5] * 6)
    assert fast[-1]["wanted"]["joints"]["my-arm"]["q"][0] == pytest.approx(0.1, abs=0.02)
    assert fast[-1]["wanted"]["joints"]["my-arm"]["qd"] == [0.2] * 6
    assert gone(str(tmp_path))


@pytest.mark.slow
def test_what_a_program_prints_is_shown_with_its_robot_within_bounds(tmp_path, capfd):
    noise = "print(chr(27) + 'x' * 10_000, file=sys.stderr); [print(i, file=sys.stderr) for i in range(500)]"
    script(
        tmp_path,
        "loud",
        REPLY.replace("GOOD", repr(GOOD)).replace("BAD", f"{noise}; print({json.dumps(GOOD)!r}, flush=True)"),
    )
    with mjsim.Simulation(room(tmp_path, "estimator: {use: 'exec:./loud'}")) as sim:
        mjsim.run(sim, seconds=0.4)
    shown = [line for line in capfd.readouterr().err.splitlines() if line.startswith("scout/estimator: ")]
    assert len(shown) == 201
    assert shown[0] == "scout/estimator: " + ("\\x1b" + "x" * 10_000)[:300]
    assert shown[-1] == "scout/estimator: (what it prints after 200 lines is not shown)"
