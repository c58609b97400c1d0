import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

import mjsim
from mjsim.interface import Observation, Odometry, Sighting
from tests.robots import pioneer

README = (Path(__file__).parent.parent / "README.md").read_text()


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", README, re.DOTALL | re.MULTILINE)


@pytest.fixture
def room(tmp_path, monkeypatch):
    """The README's world and estimator in a folder of their own, which is the working one."""
    monkeypatch.chdir(tmp_path)
    Path("room.yaml").write_text(blocks("yaml")[0])
    Path("my_slam.py").write_text(blocks("python")[0])
    return tmp_path / "room.yaml"


def test_the_readmes_estimator_holds_a_standing_robot_whose_odometry_turns_away():
    names: dict[str, type[mjsim.Estimator]] = {}
    exec(blocks("python")[0], names)
    estimator = names["MySlam"]()
    assert isinstance(estimator, mjsim.Estimator)
    estimator.start(pioneer(prior=mjsim.Pose(1.0, 1.0, 0.5)), {}, np.random.default_rng(0))
    slip = Odometry(forward=0.0, left=0.0, turn=0.001, covariance=np.eye(3) * 1e-6)
    beacon = Sighting(stamp=0.0, name="lion", range=2.0, bearing=0.3, covariance=np.eye(2) * 1e-4)
    for tick in range(1000):
        belief = estimator.update(Observation(time=0.04 * tick, dt=0.04, odometry=slip, sightings=(beacon,)))
    # The memory is off by the first tick's 1 mrad; from then on e = 0.8 (e + 1 mrad) around it, which ends at 4 mrad.
    assert belief.pose.heading - 0.5 == pytest.approx(0.005, abs=1e-9)


def test_the_readmes_world_has_no_mistake(room):
    world = mjsim.load_world(room)
    assert [beacon.name for beacon in world.beacons] == ["lion", "owl"]
    assert world.run.drivers["scout"].estimator is not None


@pytest.mark.slow
def test_the_readmes_program_runs_and_prints_its_error(room, capsys):
    exec(blocks("python")[1], {})
    assert 0.0 < float(capsys.readouterr().out) < 0.2
    recording = mjsim.read_recording("python.mcap")
    assert mjsim.statistics(recording)["scout"]["distance_m"] > 2.0


def test_what_the_readme_links_to_is_there():
    links = re.findall(r"\]\(([^)]+)\)", README)
    files = [link.partition("#")[0] for link in links if "://" not in link]
    assert not [link for link in files if not (Path(__file__).parent.parent / link).exists()]


def test_the_readme_has_at_most_130_lines():
    assert len(README.splitlines()) <= 130


def test_the_page_of_installation_lists_every_extra_with_its_packages():
    page = (Path(__file__).parent.parent / "docs" / "install.md").read_text()
    project = tomllib.loads((Path(__file__).parent.parent / "pyproject.toml").read_text())["project"]
    # evo is for tests and comparisons, peers for measurements, all for who wants every feature; an extra without
    # packages is a name of former days.
    offered = project["optional-dependencies"].items()
    extras = {name: needs for name, needs in offered if needs and name not in ("all", "evo", "peers")}
    listed = {}
    for packages, names in re.findall(r"^\| .* \| ([a-z, ;-]+) \| (`[`a-z\d; ]+) \|$", page, re.MULTILINE):
        listed |= dict(zip(re.findall(r"`(\w+)`", names), packages.split("; "), strict=True))
    assert listed == {name: ", ".join(re.split("[>=;]", need)[0] for need in needs) for name, needs in extras.items()}
