"""Checks whether MuJoCo accepts each model file of a world."""

from collections.abc import Iterator

from mjsim.compile.mechanism_models import check_mechanism_files
from mjsim.compile.obstacles import check_things
from mjsim.compile.robots import check_robots
from mjsim.errors import Problem, WorldError
from mjsim.world import World


def check_models(world: World) -> None:
    """Raise WorldError with all model files of a world that MuJoCo does not accept."""
    if problems := sorted(_problems(world)):
        raise WorldError(problems)


def _problems(world: World) -> Iterator[Problem]:
    for check in (check_things, check_robots, check_mechanism_files):
        try:
            check(world)
        except WorldError as error:
            yield from error.problems
