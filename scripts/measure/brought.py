"""Print what `mjsim new --robot-from` makes of robots in packages: a drive and its sizes, or the line of an error.

python scripts/measure/brought.py FOLDER [NAME]...

FOLDER holds the packages, unpacked; those that are not there are left out. To get them, each under its own licence:

pip download --no-deps --dest FOLDER pybullet mani_skill robosuite gymnasium-robotics safety-gymnasium
pip download --no-deps --dest FOLDER example-robot-data igibson hello-robot-stretch-urdf upkie-description
cd FOLDER; for wheel in *.whl; do unzip -q -o "$wheel" -x '*.so'; done; tar xzf igibson-*.tar.gz
"""

import argparse
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from mjsim.errors import MjsimError
from mjsim.exchange import RobotOptions, bring_robot
from mjsim.world import Source, parse_world

EXAMPLES = "cmeel.prefix/share/example-robot-data/robots"
TURTLEBOT = "igibson-*/igibson/examples/ros/igibson-ros/turtlebot"


@dataclass(frozen=True, slots=True)
class Candidate:
    """A robot of a package."""

    package: str
    path: str
    """In the folder; with * for versions."""
    options: RobotOptions = field(default_factory=RobotOptions)
    packages: Mapping[str, str] = field(default_factory=dict)


ROBOTS = {
    "husky": Candidate("pybullet", "pybullet_data/husky/husky.urdf"),
    "racecar": Candidate("pybullet", "pybullet_data/racecar/racecar.urdf"),
    "racecar_differential": Candidate("pybullet", "pybullet_data/racecar/racecar_differential.urdf"),
    "r2d2": Candidate("pybullet", "pybullet_data/r2d2.urdf"),
    "bike": Candidate("pybullet", "pybullet_data/bicycle/bike.urdf"),
    "tiago": Candidate("example-robot-data", f"{EXAMPLES}/tiago_description/robots/tiago.urdf"),
    "tiago_pro": Candidate(
        "example-robot-data", f"{EXAMPLES}/tiago_pro_description/robots/tiago_pro.urdf", RobotOptions(drive="mecanum")
    ),
    "pr2": Candidate("example-robot-data", f"{EXAMPLES}/pr2_description/urdf/pr2.urdf"),
    "centauro": Candidate("example-robot-data", f"{EXAMPLES}/centauro_description/urdf/centauro.urdf"),
    "fetch": Candidate("mani_skill", "mani_skill/assets/robots/fetch/fetch.urdf"),
    "mobile_panda": Candidate("mani_skill", "mani_skill/assets/robots/panda/mobile_panda_single_arm.urdf"),
    "omron": Candidate("robosuite", "robosuite/models/assets/bases/omron_mobile_base.xml"),
    "tiago_mjcf": Candidate("robosuite", "robosuite/models/assets/robots/tiago/robot.xml"),
    "fetch_mjcf": Candidate("gymnasium-robotics", "gymnasium_robotics/envs/assets/fetch/robot.xml"),
    "car": Candidate("safety-gymnasium", "safety_gymnasium/assets/xmls/car.xml"),
    "racecar_mjcf": Candidate("safety-gymnasium", "safety_gymnasium/assets/xmls/racecar.xml"),
    "stretch": Candidate(
        "hello-robot-stretch-urdf", "stretch_urdf/SE3/stretch_description_SE3_eoa_wrist_dw3_tool_sg3.urdf"
    ),
    "upkie": Candidate("upkie-description", "upkie_description/urdf/upkie.urdf"),
    "turtlebot": Candidate("igibson", f"{TURTLEBOT}/turtlebot.urdf"),
    "kobuki": Candidate("igibson", f"{TURTLEBOT}/kobuki_description/urdf/kobuki_standalone.urdf.xacro"),
}


def row(name: str, candidate: Candidate, path: Path) -> str:
    """Return what becomes of a robot, as a row of a table."""
    began = time.perf_counter()
    try:
        brought = bring_robot(
            path,
            name=name,
            options=candidate.options,
            packages={key: path.parent / value for key, value in candidate.packages.items()},
            arguments={},
        )
    except MjsimError as error:
        said = str(error).replace(str(path), path.name)
        return f"| {name} | {candidate.package} | refused | {said} | {time.perf_counter() - began:.0f} s |"
    (robot,) = parse_world(brought.text, source=Source(attached=brought.files)).robots
    drive, mended = robot.drive, sum(line.startswith("mended") for line in brought.report)
    sizes = f"wheels of {drive.driven_radius:.3f} m, turning track {drive.turning_track:.3f} m, {drive.max_speed:g} m/s"
    more = f"{len(robot.sensors)} sensors, {len(brought.files) - 1} meshes and pictures, {mended} mended"
    return f"| {name} | {candidate.package} | {drive.type} | {sizes}; {more} | {time.perf_counter() - began:.0f} s |"


def main() -> None:
    """Print the table, line by line."""
    parser = argparse.ArgumentParser(description="Print what becomes of robots in packages of others.")
    parser.add_argument("folder", type=Path, help="of the unpacked packages")
    parser.add_argument("names", nargs="*", metavar="NAME", help="all of them unless some are named")
    options = parser.parse_args()
    print("| robot | package | drive | sizes, or why not | took |")
    print("|---|---|---|---|---|")
    for name in options.names or ROBOTS:
        found = sorted(options.folder.glob(ROBOTS[name].path))
        if found:
            print(row(name, ROBOTS[name], found[0]), flush=True)


if __name__ == "__main__":
    main()
