"""What the source of a module says of it: the types of its options, and the readings that it needs."""

import ast

import pytest

from mjsim.modules import faults_in, offers_in
from mjsim.modules.python.annotations import schema_of
from mjsim.modules.python.offers import title_of

NUMBER = {"type": "number"}
NAMES = {"Law": ast.parse('Literal["linear", "cubic"]', mode="eval").body, "Odd": ast.parse("Odd", mode="eval").body}


@pytest.mark.parametrize(
    ("written", "about", "schema"),
    [
        ("float", "", NUMBER),
        ("int | None", "", {"anyOf": [{"type": "integer"}, {"type": "null"}]}),
        ("bool", "", {"type": "boolean"}),
        ("Literal['a', 'b']", "", {"enum": ["a", "b"]}),
        ("Law | Literal['cubic', 'spline']", "", {"enum": ["linear", "cubic", "spline"]}),
        ("Odd", "A name that stands for itself.", {}),
        ("tuple[float, float]", "", {"type": "array", "items": NUMBER, "minItems": 2, "maxItems": 2}),
        ("Sequence[float]", "Where, [x, y, z].", {"type": "array", "items": NUMBER, "minItems": 3, "maxItems": 3}),
        ("Sequence[float]", "Gains, one for each state.", {}),
        ("tuple[float, str]", "", {}),
        ("float | Mapping[str, float]", "", {}),
        ("None", "", {"type": "null"}),
    ],
)
def test_an_annotation_tells_the_type_the_choices_and_the_count_of_numbers(written, about, schema):
    assert schema_of(ast.parse(written, mode="eval").body, about, NAMES) == schema


def test_points_are_a_list_of_so_many_numbers_each():
    schema = schema_of(ast.parse("Sequence[Sequence[float]]", mode="eval").body, "Each (x, y) [m].", {})
    assert schema == {"type": "array", "items": {"type": "array", "items": NUMBER, "minItems": 2, "maxItems": 2}}
    assert schema_of(None, "", {}) == {}


def test_choices_and_defaults_are_followed_into_the_files_that_name_them(tmp_path):
    kinds, own = tmp_path / "kinds.py", tmp_path / "own.py"
    kinds.write_text('from typing import Literal\nWay = Literal["left", "right"]\nDELAY = 0.05\n')
    own.write_text(
        "class Own:\n"
        "    def __init__(self, *, way: Way = 'left', delay: float = DELAY, far: float = 2 * DELAY): ...\n"
        "    def start(self, robot, map, rng): ...\n    def command(self, seen, belief): ...\n"
    )
    (offer,) = offers_in([(kinds, "kinds.py"), (own, "own.py")])
    assert [(key.name, key.default, key.schema) for key in offer.keys] == [
        ("way", "left", {"enum": ["left", "right"]}),
        ("delay", 0.05, NUMBER),
        ("far", None, NUMBER),
    ]


def test_a_module_fits_only_robots_that_its_start_does_not_refuse(tmp_path):
    starts = {
        "Arm": "if self.arm not in r.arms: raise ValueError(r.name)",
        "Way": "if r.max_left == 0.0 or r.max_speed == 0.0: raise ValueError('no')",
        "Any": "self.arms = r.arms",
    }
    head = "class {}:\n    def command(self, seen, belief): ...\n    def start(self, r, map, rng):\n        {}\n"
    file = tmp_path / "own.py"
    file.write_text("".join(head.format(*item) for item in starts.items()))
    assert [set(offer.parts) for offer in offers_in([(file, "own.py")])] == [{"arms"}, {"max_left"}, set()]


def test_files_that_cannot_be_imported_are_named_with_the_line_that_says_why(tmp_path):
    texts = {
        "torn.py": "import math\nclass Own(:\n",
        "lacking.py": "import math, numpy.linalg\nfrom good import x\nimport no_such_thing.part\n",
        "good.py": "from __future__ import annotations\nfrom . import lacking\nx = 1\n",
    }
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    assert dict(faults_in([(tmp_path / name, f"in/{name}") for name in texts])) == {
        "in/torn.py": "torn.py:2: invalid syntax; this is not Python",
        "in/lacking.py": "lacking.py:3: no module 'no_such_thing' is installed or beside it",
    }


def test_classes_are_called_as_people_write_them():
    names = ("EkfSlam", "TextbookFastSlam", "GraphSlam", "LidarSlam", "UkfLocalization", "Lqr", "GoToGoal", "my_slam")
    titles = ["EKF-SLAM", "Textbook FastSLAM", "GraphSLAM", "Lidar SLAM", "UKF Localization", "LQR", "Go To Goal"]
    assert [title_of(name) for name in names] == [*titles, "my_slam"]


def test_a_class_that_starts_as_modules_do_and_lacks_the_method_of_a_role_is_told_of(tmp_path):
    (tmp_path / "mine.py").write_text(
        "class Slam:\n    def start(self, robot, catalogue, rng): ...\n    def step(self, seen): ...\n"
        "class Whole:\n    def start(self, robot, catalogue, rng): ...\n    def update(self, seen): ...\n"
        "class Motor:\n    def start(self): ...\n"
    )
    (place, reason), *others = faults_in([(tmp_path / "mine.py", "mine.py")])
    assert place == "mine.py:Slam"
    assert (
        reason
        == "it has start(), but none of adjust(), command(), observe(), torques(), update(); add the method of its role"
    )
    assert others == []
