"""Small facts about files of models: each formula computed another way, each repair on the smallest file."""

import math
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from mjsim.models import line_and_column, line_of, names_in
from mjsim.models.inertia_repair import finite_number, mend_inertias, mend_weightless, mended
from mjsim.models.model_sources import ModelFiles
from mjsim.models.robots.xml_positions import PlacedError, element_of, numbered, plainly, starts
from mjsim.models.trials import model as model_fault
from mjsim.models.trials import picture as picture_fault
from tests.models.small_files import GOOD, SHAPE, link, urdf

XML = b"<a>\n  <b name=\"left\"/>\n  <c  name='right'><b/></c>\n</a>"


def test_elements_are_told_by_line_and_column():
    assert starts(XML) == [("a", 1, 1), ("b", 2, 3), ("c", 3, 3), ("b", 3, 20)]
    assert starts(b"<a>\n<b/>\n<") == [("a", 1, 1), ("b", 2, 1)]
    assert line_of("left", XML) == ("b", 2, 3)
    assert line_of("right", XML) == ("c", 3, 3)
    assert line_of("none", XML) is None
    assert [line_and_column(XML.index(word), XML) for word in (b"<a", b"left", b"</a")] == [(1, 1), (2, 12), (4, 1)]
    assert names_in("joint 'a' of 'b c' and 'd'") == ["a", "d"]
    root = ET.fromstring(XML)
    origins = numbered(root, "f.xml")
    assert [(origins[each].path, origins[each].number) for each in root.iter()] == [("f.xml", k) for k in range(4)]
    error = PlacedError("f.xml", starts(XML)[1], "wrong")
    assert (str(error), error.path, error.what) == ("'f.xml':2:3: wrong", "f.xml", "wrong")


@pytest.mark.parametrize(
    ("error", "found"),
    [
        ("XML Error: bad\nElement 'b', line 2", 1),
        ("Element name 'right', id 1", 2),
        ("name 'left' twice", 1),
        ("line 3", None),  # two begin there
        ("Element 'b', line 3", 3),
        ("Element 'q', line 3", None),
        ("no words", None),
        ("name 'none'", None),
    ],
)
def test_errors_of_mujoco_lead_to_their_element(error, found):
    root = ET.fromstring(XML)
    assert element_of(error, root) is (None if found is None else list(root.iter())[found])


def test_errors_of_mujoco_are_told_plainly():
    element = ET.fromstring('<geom name="g"/>')
    said = "XML Error: size 0 must be positive\nElement 'geom', line 7"
    assert plainly(said, element) == "<geom> 'g': size 0 must be positive"
    assert plainly("Error: mass is 0.", ET.fromstring("<body/>")) == "<body>: mass is 0"


def test_trials_say_what_is_wrong_or_nothing():
    from mjsim.models import encode_png

    assert picture_fault(encode_png(np.zeros((2, 2, 3), np.uint8))) is None
    assert picture_fault(b"no picture") is not None
    good = '<mujoco><worldbody><geom size="1"/></worldbody></mujoco>'
    for text, wrong in ((good, False), (good.replace('"1"', '"-1"'), True)):
        files = ModelFiles(ET.fromstring(text), {}, ("m.xml",))
        assert (model_fault(files) is not None) == wrong


@pytest.mark.parametrize(
    ("given", "moments", "word"),
    [
        ((1.0, 2.0, 2.5), None, None),
        ((1.0, 1.0, 2.0001), None, None),  # within the tolerance
        ((1.0, 1.0, 2.2), None, "slightly misses the triangle inequality"),
        ((0.5, 0.5, 4.0), None, "breaks the triangle inequality"),
        ((0.0, 1.0, 3.0), (1.5, 1.5, 3.0), "has a principal moment of "),
        ((-1e-12, 3.0, 3.0), (1.5, 3.0, 3.0), "is that of a rod without thickness"),
        ((-1.0, 2.0, 3.0), (1.5, 2.0, 3.0), "has a principal moment of -1 kg m^2"),
        ((1e-15, 1e-15, 1e-14), None, None),  # MuJoCo takes its own
        ((math.nan, 1.0, 1.0), (1e-6,) * 3, "is no number"),
    ],
)
def test_an_inertia_is_mended_in_its_own_axes(given, moments, word):
    turn = np.linalg.qr(np.array([[1.0, 2, 3], [0, 1, 4], [5, 6, 0]]))[0]
    found = mended(turn @ np.diag(given) @ turn.T)
    if word is None:
        assert found is None
        return
    matrix, said = found
    values = np.linalg.eigvalsh(matrix)
    assert said.startswith(word)
    assert values[2] < values[0] + values[1]
    if moments is not None:
        assert values == pytest.approx(moments)
    else:
        assert values[0] + values[1] - values[2] < 1e-6
        # The axes stay.
        assert turn.T @ matrix @ turn == pytest.approx(np.diag(np.diag(turn.T @ matrix @ turn)), abs=1e-9)


BODY = '<mujoco><worldbody><body name="b"><inertial pos="0 0 0" {}/></body></worldbody></mujoco>'


@pytest.mark.parametrize(
    ("text", "said", "left"),
    [
        (link("a", "2", GOOD), [], "2"),
        (link("a", "2"), ["link 'a' has no inertia; made 0.002 kg m^2, that of a ball of 0.05 m"], "2"),
        (link("a", "0", GOOD, SHAPE), ["has a mass of 0 kg; its shapes get a density of 1000"], None),
        (link("a", "x", GOOD), ["has a mass of nothing kg; it gets a negligible mass"], None),
        (link("a", "1", GOOD) + link("b", None, "", SHAPE), ["link 'b' has no mass; its shapes get"], "1"),
        (link("a", "1", GOOD) + link("b"), [], "1"),
        (link("a", None, "", SHAPE), [], None),
        (link("a", "2", GOOD.replace('izz="1"', 'izz="4"')), ["the inertia of link 'a' breaks the triangle"], "2"),
        (link("a", "2", GOOD.replace('"1"', '"1e-15"')), ["no inertia (its file says 1e-15, 1e-15, 1e-15); made"], "2"),
    ],
)
def test_masses_of_urdf_are_mended_link_by_link(text, said, left):
    root = urdf(text)
    notes = mend_inertias(root, "r.urdf")
    assert len(notes) == len(said)
    assert all(word in note for word, note in zip(said, notes, strict=True))
    mass = root.find("link/inertial/mass")
    assert (None if mass is None else mass.get("value")) == left
    if left == "2":
        moments = [float(root.find("link/inertial/inertia").get(key)) for key in ("ixx", "iyy", "izz")]
        assert max(moments) < sum(moments) / 2 + 1e-6
        if "no inertia" in "".join(said):
            assert moments == [pytest.approx(0.4 * 2 * 0.05**2)] * 3


def test_a_link_held_to_one_with_mass_weighs_nothing():
    held = '<joint name="j{0}" type="{1}"><parent link="{2}"/><child link="{3}"/></joint>'
    joints = (
        held.format(1, "fixed", "a", "b") + held.format(2, "fixed", "b", "c") + held.format(3, "revolute", "c", "d")
    )
    root = urdf(
        link("a", "1", GOOD) + link("b", None, "", SHAPE) + link("c", "-1", GOOD) + link("d", "0", GOOD), joints
    )
    notes = mend_inertias(root, "r.urdf", feather=1e-3)
    assert [note.split("'")[1] for note in notes] == ["c", "d"]
    assert "has a mass of -1 kg; it gets a negligible mass instead" in notes[0]
    for found in root.findall("link")[1:3]:
        (inertial,) = found.findall("inertial")
        assert float(inertial.find("mass").get("value")) == 1e-3
        assert float(inertial.find("inertia").get("ixx")) == pytest.approx(1e-7)
        assert float(inertial.find("inertia").get("ixy")) == 0.0


@pytest.mark.parametrize(
    ("inertial", "said", "key", "values"),
    [
        ('mass="1" diaginertia="1 1 3"', "breaks the triangle inequality", "diaginertia", (1.5, 1.5, 3.0)),
        ('mass="1" fullinertia="1 1 3 0 0 0"', "breaks the triangle inequality", "fullinertia", None),
        ('mass="0" diaginertia="1 1 1"', "has a mass of 0 kg; its mass is computed from its shapes", None, None),
        ('mass="1" diaginertia="1 1 1"', None, "diaginertia", (1.0, 1.0, 1.0)),
        ('mass="1" diaginertia="1 1"', None, "diaginertia", (1.0, 1.0)),
    ],
)
def test_inertias_of_mjcf_are_mended_where_they_stand(inertial, said, key, values):
    root = ET.fromstring(
        f'<mujoco><worldbody><body name="b"><inertial pos="0 0 0" {inertial}/></body></worldbody></mujoco>'
    )
    notes = mend_inertias(root, "m.xml")
    assert len(notes) == (said is not None)
    assert all(said in note and "body 'b'" in note for note in notes)
    found = root.find(".//inertial")
    if key is None:
        assert found is None
        return
    assert set(found.attrib) == {"pos", "mass", key}
    numbers = np.array(found.get(key).split(), dtype=float)
    if values is not None and said is None:
        assert numbers == pytest.approx(values)
    if said is not None:
        assert len(numbers) == (3 if key == "diaginertia" else 6)
        assert np.sort(numbers[:3])[2] <= np.sort(numbers[:3])[:2].sum() * 1.00001


def test_the_matrix_of_six_numbers_has_the_order_of_mjcf():
    given = "1 2 9 0.1 0.2 0.3"
    root = ET.fromstring(
        f'<mujoco><worldbody><body><inertial mass="1" fullinertia="{given}"/></body></worldbody></mujoco>'
    )
    (note,) = mend_inertias(root, "m.xml")
    a, b, c, ab, ac, bc = map(float, given.split())
    small, middle, large = np.linalg.eigvalsh(np.array([[a, ab, ac], [ab, b, bc], [ac, bc, c]]))
    assert f"({small:.3g} + {middle:.3g} < {large:.3g} kg m^2)" in note


def test_a_robot_without_mass_weighs_what_its_shapes_do():
    visual = '<visual><geometry><box size="1 1 1"/></geometry></visual>'
    root = urdf(link("a", None, "", visual) + link("b", None, "", visual + SHAPE))
    (note,) = mend_weightless(root, "r.urdf")
    assert "no link has a mass" in note
    assert [len(each.findall("collision")) for each in root] == [1, 1]
    assert [len(each.findall("visual")) for each in root] == [1, 1]
    for other in (urdf(link("a", "1", "", visual)), ET.fromstring("<mujoco/>")):
        assert list(mend_weightless(other, "r.urdf")) == []
    assert [finite_number(text) for text in ("1e2", "inf", "x", "", None)] == [100.0, None, None, None, None]
