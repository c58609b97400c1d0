"""What a class needs to fill a role is found without making an instance of it."""

import inspect
import subprocess

import pytest

from mjsim import interface
from mjsim.modules import ROLES, misfit
from mjsim.sim.bases.differential import DifferentialKinematics

PROTOCOLS = {
    "observer": interface.Observer,
    "estimator": interface.Estimator,
    "navigator": interface.Navigator,
    "avoidance": interface.Avoidance,
    "controller": interface.Controller,
    "drive": interface.DriveModel,
}


class Fits:
    def __init__(self):
        raise AssertionError("the check must not make an instance")

    def start(self, *arguments):
        pass

    observe = update = command = adjust = torques = wheels_from_twist = twist_from_wheels = start


class Traps(type):
    def __getattr__(cls, name):
        raise AssertionError("the check must not run code of the class")


@pytest.mark.parametrize("role", ROLES)
def test_a_role_requires_the_methods_of_its_protocol(role):
    methods = {n for n, v in vars(PROTOCOLS[role]).items() if inspect.isfunction(v) and not n.startswith("_")}
    assert set(ROLES[role]) == methods


@pytest.mark.parametrize("role", ROLES)
def test_a_class_with_the_methods_fits_and_is_not_made(role):
    assert misfit(role, Fits) is None


@pytest.mark.parametrize("role", ROLES)
def test_unrelated_classes_and_functions_are_refused_as_modules(role):
    assert misfit(role, subprocess.Popen) is not None
    assert misfit(role, subprocess.run) is not None


def test_the_sentence_names_what_is_missing():
    class NoStart:
        def update(self, seen):
            pass

    assert misfit("estimator", NoStart) == "has no method start(); an estimator needs start() and update()"
    assert (
        misfit("navigator", NoStart) == "has no methods start() and command(); a navigator needs start() and command()"
    )
    assert misfit("observer", inspect) == "is a value of type module; an observer is a class with start() and observe()"


def test_a_coroutine_and_a_number_are_no_methods():
    class Async(Fits):
        async def update(self, seen):
            pass

    class Number(Fits):
        update = 3

    assert (
        misfit("estimator", Async) == "has `async def update`; write `def update`, since the simulator does not await"
    )
    assert misfit("estimator", Number) == "has update = 3; it must be a method"


def test_no_code_of_the_class_runs():
    class Lazy(metaclass=Traps):
        def start(self, robot, catalogue, rng):
            pass

    assert misfit("estimator", Lazy) == "has no method update(); an estimator needs start() and update()"


def test_kinds_of_methods_that_python_has_fit():
    class Kinds(Fits):
        @staticmethod
        def start(robot, catalogue, rng):
            pass

        @classmethod
        def update(cls, seen):
            pass

    assert misfit("estimator", Kinds) is None
    assert misfit("drive", DifferentialKinematics) is None
