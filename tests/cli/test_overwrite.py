"""Recordings are not lost without a word, whichever way they are made."""

import os
import shutil
from functools import partial
from pathlib import Path

import pytest
from typer.main import get_command

import mjsim
from mjsim.cli import app
from mjsim.ergonomics import workplace_study
from mjsim.ergonomics.reach import AZIMUTHS, ELEVATIONS, reach_envelope
from tests.cli.shell import ROOM, shell, typed, wait_for_ticks

CONSTANT = "mjsim.algorithms.constant:ConstantCommand"

SAID = "exists; name another file, or add --overwrite (in Python: overwrite=True)"


@pytest.mark.usefixtures("room")
@pytest.mark.slow
class TestTheCommandRun:
    def test_takes_the_next_free_name_unless_one_is_given(self, capsys):
        names = [typed("run", "room.yaml", "--seconds", "0.2", capsys=capsys)[1] for _ in range(3)]
        assert names == ["out/room/run.mcap\n", "out/room/run-2.mcap\n", "out/room/run-3.mcap\n"]
        assert typed("run", "room.yaml", "--seconds", "0.4", "--overwrite", capsys=capsys)[1] == names[0]
        ends = [mjsim.read_recording(name.strip()).time[-1] for name in names]
        assert ends == pytest.approx([0.36, 0.16, 0.16])

    def test_refuses_a_file_that_exists_before_it_looks_at_the_world(self, capsys):
        Path("run.mcap").write_bytes(b"precious")
        Path("film.mp4").write_bytes(b"precious")
        for words in (("-o", "run.mcap"), ("-o", "new.mcap", "--video", "film.mp4")):
            code, out, err = typed("run", "none.yaml", *words, capsys=capsys)
            assert (code, out, err) == (2, "", f"'{words[-1]}' {SAID}\n")
        assert Path("run.mcap").read_bytes() == Path("film.mp4").read_bytes() == b"precious"
        assert not Path("new.mcap").exists()

    def test_refuses_a_recording_under_the_name_of_something_else(self, capsys):
        for words in (
            ("run", "room.yaml", "-o", "film.mp4"),
            ("import-log", "room.yaml", "-o", "run.bag"),
            ("bridge", "room.yaml", "-o", "run.csv"),
        ):
            code, out, err = typed(*words, capsys=capsys)
            assert (code, out, err) == (2, "", f"cannot write a recording as '{words[-1]}'; name it .mcap\n")
            assert not Path(words[-1]).exists()

    @pytest.mark.parametrize(
        ("key", "value"), [("robots.scout.preset", "none"), ("run.drivers.scout.navigator.speed", "fast")]
    )
    def test_keeps_the_old_recording_when_the_new_run_cannot_begin(self, key, value, capsys):
        Path("run.mcap").write_bytes(b"precious")
        words = ("run", "room.yaml", "-o", "run.mcap", "--overwrite", "--set", f"{key}={value}")
        assert typed(*words, capsys=capsys)[0] != 0
        assert Path("run.mcap").read_bytes() == b"precious"
        assert {*os.listdir()} - {"__pycache__"} == {"forward.py", "room.yaml", "run.mcap"}
        assert typed("run", "room.yaml", "-o", "run.mcap", "--overwrite", capsys=capsys)[0] == 0
        assert mjsim.read_recording("run.mcap").whole

    def test_at_a_file_that_another_run_writes_is_one_line_with_and_without_overwrite(self, capsys):
        with shell("run", "room.yaml", "-o", "run.mcap", "--seconds", "600", "--realtime") as first:
            wait_for_ticks("run.mcap")
            code, out, err = typed("run", "room.yaml", "-o", "run.mcap", capsys=capsys)
            assert (code, out, err) == (2, "", f"'run.mcap' {SAID}\n")
            code, out, err = typed("run", "room.yaml", "-o", "run.mcap", "--overwrite", capsys=capsys)
            assert (code, out) == (2, "")
            assert err == "'run.mcap' is being written; wait for that to end, or name another file\n"
            assert first.runs()
        killed = mjsim.read_recording("run.mcap")
        assert not killed.whole
        assert typed("run", "room.yaml", "-o", "run.mcap", capsys=capsys)[0] == 2
        assert len(mjsim.read_recording("run.mcap").time) == len(killed.time)
        assert typed("run", "room.yaml", "-o", "run.mcap", "--overwrite", capsys=capsys)[0] == 0
        assert mjsim.read_recording("run.mcap").whole

    def test_twice_at_once_writes_one_recording_and_refuses_the_other(self):
        words = ("run", "room.yaml", "-o", "run.mcap", "--seconds", "2", "--realtime")
        with shell(*words) as one, shell(*words) as other:
            codes = [process.ended() for process in (one, other)]
            told = [(process.rest("stdout"), process.rest("stderr")) for process in (one, other)]
        assert sorted(codes) == [0, 2]
        out, err = told[codes.index(2)]
        assert out == ""
        assert err in (
            f"'run.mcap' {SAID}\n",
            "'run.mcap' is being written; wait for that to end, or name another file\n",
        )
        assert mjsim.read_recording("run.mcap").time[-1] == pytest.approx(1.96)


def test_in_python_a_run_and_a_replay_replace_a_file_only_when_told(tmp_path: Path):
    world = mjsim.parse_world(
        "mjsim: 1\nrobots: [{name: scout, preset: pioneer3dx, at: [0, 0]}]\nrun: {seconds: 0.2}\n"
    )
    path = tmp_path / "run.mcap"
    with mjsim.Simulation(world) as sim:
        run = mjsim.run(sim, drivers={"scout": mjsim.Driver()}, record=path)
        before = path.read_bytes()
        with pytest.raises(mjsim.UsageError, match="exists"):
            mjsim.run(sim, record=path)
        (tmp_path / "other.mcap").write_bytes(b"precious")
        with pytest.raises(mjsim.UsageError, match="exists"):
            mjsim.replay(run, robot="scout", estimator=Lost(), record=tmp_path / "other.mcap")
        with pytest.raises(mjsim.ModuleFault):
            mjsim.replay(run, robot="scout", estimator=Lost(), record=tmp_path / "other.mcap", overwrite=True)
        assert (tmp_path / "other.mcap").read_bytes() == b"precious"
        assert path.read_bytes() == before
        mjsim.run(sim, seconds=0.4, record=path, overwrite=True)
    assert len(mjsim.read_recording(path).time) == 10


STOOL = """
mjsim: 1
obstacles: [{name: stool, cylinder: [0.17, 0.42], at: [1, 2], seat: {at: [0, 0, 0.51]}}]
people: [{name: anna, sex: female, seat: stool}]
"""


class Lost:
    """An estimator that fails at the first tick."""

    def start(self, robot, catalogue, rng):
        pass

    def update(self, seen):
        raise ValueError("lost")


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a world that has a camera, a recording of it, and a world with a plant."""
    folder = tmp_path_factory.mktemp("made")
    (folder / "motor.yaml").write_text("mjsim: 1\nplants: [{name: motor, tf: {num: [12], den: [1, 1.09]}}]\n")
    (folder / "stool.yaml").write_text(STOOL)
    (folder / "curve.m").write_text("plot([1 2 3]);\n")
    (folder / "room.yaml").write_text(ROOM.replace('"forward.py:Forward", speed', f'"{CONSTANT}", forward'))
    with mjsim.Simulation(mjsim.load_world(folder / "room.yaml")) as sim:
        mjsim.run(sim, seconds=0.4, record=folder / "run.mcap")
    return folder


COMMANDS = {
    "video": ("video run.mcap --view plan -o film.mp4", "film.mp4"),
    "report": ("report run.mcap -o report", "report/statistics.json"),
    "compare": ("compare run.mcap -o both", "both/comparison.json"),
    "tum": ("export run.mcap --tum tum", "tum/scout_truth.tum"),
    "csv": ("export run.mcap --csv csv", "csv/scout_track.csv"),
    "npz": ("export run.mcap --npz run.npz", "run.npz"),
    "mat": ("export run.mcap --mat run.mat", "run.mat"),
    "images": ("export run.mcap --images images", "images/scout/front/00000000.000000.jpg"),
    "rosbag2": ("export run.mcap --rosbag2 bag", "bag/metadata.yaml"),
    "carmen": ("export run.mcap --carmen run.log", "run.log"),
    "compile": ("compile room.yaml -o scene", "scene/scene.xml"),
    "arm": ("arm puma560 --plot puma.png", "puma.png"),
    "show": ("show room.yaml -o plan.png", "plan.png"),
    "view": ("show room.yaml --view scout/front -o view.jpg", "view.jpg"),
    "lab": ("lab motor.yaml -o lab", "lab/motor.html"),
    "octave": ("octave curve.m -o curves", "curves/figure-1.png"),
    "ergonomics": ("ergonomics stool.yaml -o people --formats pdf,svg", "people/anna_reach.pdf"),
    "new": ("new --maze 3x3 -o maze.yaml", "maze.yaml"),
    "worlds": ("worlds --copy gallery -o mine.yaml", "mine.yaml"),
    "map": ("export-world room.yaml --map map", "map/map.yaml"),
    "sdf": ("export-world room.yaml --sdf room.sdf", "room.sdf"),
    "glb": ("export-world room.yaml --glb room.glb", "room.glb"),
    "svg": ("export-world room.yaml --svg room.svg", "room.svg"),
    "replay": (
        "replay run.mcap --robot scout --estimator mjsim.algorithms.ekf_slam:EkfSlam -o again.mcap",
        "again.mcap",
    ),
    "doctor": ("doctor -o picture.png", "picture.png"),
}
"""Command line and a file that it writes."""
WRITES_NOTHING = {"check", "schema", "bench", "fmt", "studio", "sweep", "run", "import-log", "calibrate", "experiments"}
"""`fmt` writes in place; a sweep goes on where it was; the last three are tested elsewhere or take minutes."""


def test_every_command_that_takes_an_output_has_the_option():
    commands = get_command(app()).commands
    tested = {line.split()[0] for line, _ in COMMANDS.values()}
    assert set(commands) - WRITES_NOTHING <= tested | {"bridge"}
    for name, command in commands.items():
        options = {option for parameter in command.params for option in parameter.opts}
        if options & {"-o", "--tum", "--map"} and name != "sweep":
            assert "--overwrite" in options, name


@pytest.mark.slow
@pytest.mark.parametrize(("line", "file"), COMMANDS.values(), ids=COMMANDS)
def test_every_command_refuses_what_exists_keeps_what_is_not_its_own_and_obeys_overwrite(
    line: str, file: str, made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
):
    if line.startswith("octave") and shutil.which("octave-cli") is None:
        pytest.skip("no Octave here")
    few = partial(reach_envelope, azimuths=AZIMUTHS[::4], elevations=ELEVATIONS[::4])
    monkeypatch.setattr(workplace_study, "reach_envelope", few)  # all directions take 5 s
    shutil.copytree(made, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    place = Path(file)
    place.parent.mkdir(parents=True, exist_ok=True)
    place.write_bytes(b"precious")
    (place.parent / "notes.txt").write_text("mine")
    before = sorted(Path().rglob("*"))
    code, out, err = typed(*line.split(), capsys=capsys)
    assert (code, out) == (2, "")
    assert err.count("\n") == 1
    assert "name another f" in err
    assert "add --overwrite" in err
    assert sorted(Path().rglob("*")) == before
    assert place.read_bytes() == b"precious"
    assert typed(*line.split(), "--overwrite", capsys=capsys)[0] == 0
    assert place.read_bytes() != b"precious"
    assert (place.parent / "notes.txt").read_text() == "mine"
    assert typed(*line.split(), capsys=capsys)[0] == 2
    assert {path.name for path in Path().rglob(".*")} <= {".mjsim-files.json"}  # which plots of a report are ours


def test_new_still_takes_force(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("maze.yaml").write_text("precious")
    assert typed("new", "--maze", "3x3", "-o", "maze.yaml", "--force", capsys=capsys)[0] == 0
    assert Path("maze.yaml").read_text() != "precious"


@pytest.mark.slow
def test_an_export_over_the_recording_itself_is_refused_even_to_overwrite(made: Path, tmp_path: Path, capsys):
    file = tmp_path / "run.mcap"
    shutil.copy(made / "run.mcap", file)
    code, _, err = typed("export", str(file), "--npz", str(file), "--overwrite", capsys=capsys)
    assert (code, err) == (2, f"'{file}' is the recording itself; name another file\n")
    assert len(mjsim.read_recording(file).time) == 10
