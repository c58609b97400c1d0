"""Operators, functions, costs and properties of xacro by themselves."""

import math

import pytest

from mjsim.models.xacro.budget import STEPS, TooLargeError, XacroBudget, XacroError, size_of, weight_of
from mjsim.models.xacro.scope import Scope
from mjsim.models.xacro.xacro_functions import BINARY, METHODS, SUBSTITUTED, known_names


@pytest.mark.parametrize(
    ("name", "left", "right", "value"),
    [
        ("Pow", 2, 10, 1024), ("Pow", 2.0, -1, 0.5), ("Mult", 3, 4, 12), ("Mult", "ab", 2, "abab"), ("Mod", 7, 3, 1),
        ("Mod", "%.2f m", 1.5, "1.50 m"), ("Mod", "100%%", (), "100%"), ("Div", 1, 4, 0.25), ("FloorDiv", 7, 2, 3),
        ("Pow", -8, 1 / 3, XacroError), ("Pow", 2, 200, TooLargeError), ("Mult", "x", 10**6, TooLargeError),
        ("Mult", 10**6, [0], TooLargeError), ("Mod", "%1000d", 1, XacroError), ("Pow", 1, 10**9, 1),
        ("Mod", "%s" * 1000, ("x",) * 1000, TooLargeError),
    ],
)  # fmt: skip
def test_operators_of_xacro_are_those_of_python_within_bounds(name, left, right, value):
    if isinstance(value, type):
        with pytest.raises(value):
            BINARY[name](left, right)
    else:
        assert BINARY[name](left, right) == value


@pytest.mark.parametrize(
    ("name", "arguments", "value"),
    [
        ("factorial", (5,), 120), ("factorial", (200,), math.factorial(200)), ("factorial", (201,), TooLargeError),
        ("round", (1.26, 1), 1.3), ("round", (1.26, 31), TooLargeError), ("sum", ([1, 2, 3],), 6), ("sum", ([1], 4), 5),
        ("sum", (["a"],), XacroError), ("range", (3,), [0, 1, 2]), ("range", (10_000,), list(range(10_000))),
        ("range", (10_001,), TooLargeError), ("zip", ([1], [2]), [(1, 2)]), ("enumerate", (["a"],), [(0, "a")]),
        ("reversed", ([1, 2],), [2, 1]), ("pi", None, math.pi), ("true", None, True),
    ],
)  # fmt: skip
def test_functions_of_xacro_are_those_of_python_within_bounds(name, arguments, value):
    found = SUBSTITUTED[name]
    if arguments is None:
        assert found == value
    elif isinstance(value, type):
        with pytest.raises(value):
            found.run(*arguments)
    else:
        assert found.run(*arguments) == value
    assert METHODS[dict]["items"].run({"a": 1}) == [("a", 1)]
    assert METHODS[str]["join"].run(",", ["a", "b"]) == "a,b"
    assert set(known_names({"load_yaml": len})) >= {"math", "python", "xacro", "load_yaml", "dotify", "sin"}


def test_what_a_xacro_file_costs_is_counted():
    assert [size_of(value) for value in (1, None, "abc", [1, "ab"], {"a": [1, 2]}, ())] == [1, 1, 4, 5, 6, 1]
    assert [weight_of(value) for value in ("x" * 80, [1, 2])] == [1 + 81 // 8, 3]
    for value, error in (
        ([0] * 100_000, TooLargeError),
        (2**256, TooLargeError),
        (1j, XacroError),
        ("\ud800", XacroError),
    ):
        with pytest.raises(error):
            size_of(value)
    assert size_of(2**256 - 1) == 1
    budget = XacroBudget()
    budget.spend(STEPS - 2)
    assert budget.keep([1]) == [1]
    with pytest.raises(XacroError, match="it takes more than 1000000 steps"):
        budget.spend(1)
    for _ in range(2):  # what was left counts no more
        with (
            budget.deeper(700),
            budget.deeper(50),
            pytest.raises(XacroError, match="nested too deeply"),
            budget.deeper(1),
        ):
            pass


def test_properties_of_xacro_are_looked_up_outwards_and_evaluated_once():
    asked = []

    def evaluate(text: str, scope: Scope) -> object:
        asked.append(text)
        return scope.lookup(text[1:]) if text.startswith("$") else text.upper()

    file = Scope(evaluate, known={"pi": 3.0})
    space = Scope(evaluate, parent=file, namespace=True)
    macro = Scope(evaluate, parent=space)
    file.set("a", "one", lazy=True)
    space.set("b", "two")
    assert [macro.lookup(name) for name in ("a", "a", "b", "pi")] == ["ONE", "ONE", "two", 3.0]
    assert asked == ["one"]
    assert ["a" in macro, "b" in file, "pi" in macro] == [True, False, True]
    assert (macro.outermost(), macro.caller(), space.caller()) == (file, file, file)
    with pytest.raises(XacroError, match="is for properties of macros"):
        file.caller()
    file.set("x", "$y", lazy=True)
    file.set("y", "$x", lazy=True)
    with pytest.raises(XacroError, match=r"'x' refers to itself \(x -> y -> x\)"):
        file.lookup("x")
    macro.remove("b")
    with pytest.raises(XacroError, match="no xacro:property 'b'; declare it"):
        macro.lookup("b")
