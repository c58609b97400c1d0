"""Which packages are installed: all of mjsim/, and the folders beside it that are installed below `mjsim`."""

from setuptools import find_packages, setup

BESIDE = {
    "mjsim.algorithms": "algorithms",
    "mjsim.assets": "assets",
    "mjsim.bench": "tests/bench",
    "mjsim.worlds": "worlds",
}

setup(
    packages=[
        *find_packages(include=["mjsim", "mjsim.*"]),
        *BESIDE,
        *(f"{name}.{inner}" for name, folder in BESIDE.items() for inner in find_packages(folder)),
    ],
    package_dir={"mjsim": "mjsim", **BESIDE},
)
