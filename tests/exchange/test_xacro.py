"""Xacro: plain properties, arguments and conditions resolve to what the library makes of them; macros need it."""

import itertools
import tracemalloc
from pathlib import Path
from xml.etree import ElementTree

import pytest
import xacro

from mjsim.errors import UsageError
from mjsim.exchange import RobotOptions, bring_robot
from mjsim.exchange.robots.xacro import resolved
from mjsim.exchange.robots.xacro_bounds import Bounds, TooLargeError, rewritten
from mjsim.exchange.robots.xacro_eval import require_harmless

HEAD = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">'
PLAIN = f"""{HEAD}
  <xacro:arg name="namespace" default=""/>
  <xacro:arg name="laser" default="true"/>
  <xacro:property name="namespace" value="$(arg namespace)"/>
  <xacro:property name="radius" value="0.04"/>
  <xacro:property name="track" value="${{2 * radius + 0.1}}"/>
  <link name="${{namespace}}base"/>
  <link name="${{namespace}}wheel"/>
  <joint name="${{namespace}}j" type="continuous">
    <parent link="${{namespace}}base"/><child link="${{namespace}}wheel"/>
    <origin xyz="${{-track / 2}} 0 ${{radius * cos(0)}}" rpy="${{-pi / 2}} 0 0"/>
  </joint>
  <xacro:if value="$(arg laser)"><link name="laser"/></xacro:if>
  <xacro:unless value="$(arg laser)"><link name="no_laser"/></xacro:unless>
  <xacro:if value="${{radius &gt; 1}}"><link name="huge"/></xacro:if>
</robot>"""
MACRO = f"""{HEAD}
  <xacro:macro name="wheel" params="side y">
    <link name="${{side}}">
      <inertial><mass value="0.5"/><inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial>
      <visual><geometry><mesh filename="$(find mine)/meshes/tyre.stl"/></geometry></visual>
      <collision><origin rpy="1.5708 0 0"/><geometry><cylinder radius="0.08" length="0.03"/></geometry></collision>
    </link>
    <joint name="${{side}}_joint" type="continuous">
      <parent link="base"/><child link="${{side}}"/><origin xyz="0 ${{y}} 0"/><axis xyz="0 1 0"/>
    </joint>
  </xacro:macro>
  <link name="base">
    <inertial><mass value="5"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size="0.4 0.3 0.1"/></geometry></collision>
  </link>
  <xacro:wheel side="left" y="0.2"/>
  <xacro:wheel side="right" y="-0.2"/>
</robot>"""


def shape_of(data: bytes) -> list[tuple[str, dict[str, object]]]:
    """Return the elements of a description with their attributes, numbers as numbers."""

    def value(text: str) -> object:
        try:
            return [round(float(word), 9) for word in text.split()]
        except ValueError:
            return text

    return [(item.tag, {k: value(v) for k, v in item.attrib.items()}) for item in ElementTree.fromstring(data).iter()]


@pytest.mark.parametrize("arguments", [{}, {"namespace": "a_"}, {"laser": "false"}])
def test_plain_xacro_is_what_the_library_makes_of_it(tmp_path, arguments):
    place = tmp_path / "r.urdf.xacro"
    place.write_text(PLAIN)
    ours = resolved(PLAIN.encode(), place, arguments=arguments, find=lambda _: None)
    theirs = xacro.process_file(str(place), mappings=arguments).toxml().encode()
    assert shape_of(ours) == shape_of(theirs)


def test_a_namespace_that_nobody_declared_is_empty_or_what_is_given():
    text = b'<robot name="r"><link name="${namespace}base"/></robot>'
    for arguments, base in (({}, "base"), ({"namespace": "a_"}, "a_base")):
        root = ElementTree.fromstring(resolved(text, Path("r.urdf"), arguments=arguments, find=lambda _: None))
        assert root.find("link").get("name") == base


@pytest.mark.slow
def test_macros_are_expanded_by_the_library_and_packages_found(tmp_path):
    place = tmp_path / "r.urdf.xacro"
    place.write_text(MACRO)
    (tmp_path / "mine").mkdir()
    brought = bring_robot(place, name="r", options=RobotOptions(), packages={"mine": tmp_path / "mine"}, arguments={})
    assert "left out: missing meshes, 2 of them; collision shapes are used instead" in brought.report
    assert 'left: {joint: "left_joint"' in brought.text


@pytest.mark.parametrize(
    ("text", "what"),
    [
        (f'{HEAD}<xacro:property name="a" value="${{b}}"/><xacro:property name="b" value="${{a}}"/>'
         '<link name="${a}"/></robot>', "refers to itself"),
        (f'{HEAD}<link name="${{gone}}"/></robot>', "no xacro:property 'gone'; declare it"),
        (f"{HEAD}<xacro:nothing/></robot>", "is not valid xacro"),
        (f'{HEAD}<xacro:include filename="$(find far)/x.xacro"/></robot>', "names the package 'far'"),
    ],
)  # fmt: skip
def test_what_is_wrong_in_xacro_is_told_in_one_line(tmp_path, text, what):
    place = tmp_path / "r.urdf.xacro"
    place.write_text(text)
    with pytest.raises(UsageError, match=what) as caught:
        resolved(text.encode(), place, arguments={}, find=lambda _: None)
    assert len(str(caught.value).splitlines()) == 1


CLASSES = "[c for c in x.__class__.__base__.__subclasses__() if c.__name__ == '_wrap_close']"


@pytest.mark.parametrize(
    ("expression", "what"),
    [
        (f"[{CLASSES}[0].__init__.__globals__['system']('touch ran') for x in [()]]", "'__globals__' is not allowed"),
        ("(lambda: 1)()", "Lambda is not allowed"),
        ("[g.gi_frame for g in [(x for x in [])]]", "'gi_frame' is not allowed"),
        ("9**9**9", r"has a power; exponents are numbers up to 10"),
        ("1 &lt;&lt; 10000000000", "LShift is not allowed"),
        ("'x' * 1000001", "a number or a text that is too large"),
    ],
)
def test_expressions_of_a_file_only_compute(tmp_path, monkeypatch, expression, what):
    monkeypatch.chdir(tmp_path)
    text = f'{HEAD}<xacro:property name="a" value="${{{expression}}}"/><link name="base"/><link name="${{a}}"/></robot>'
    (tmp_path / "robot.xacro").write_text(text)
    with pytest.raises(UsageError, match=what):
        resolved(text.encode(), tmp_path / "robot.xacro", arguments={}, find=lambda _: None)
    assert [each.name for each in tmp_path.iterdir()] == ["robot.xacro"]


def test_expressions_that_only_compute_are_those_of_the_library(tmp_path):
    value = "${[2**3, -4, 5][0] + max(1, 2)}"
    text = f"{HEAD}<xacro:property name='a' value='{value}'/><link name='l${{a}}'/></robot>"
    (tmp_path / "robot.xacro").write_text(text)
    made = resolved(text.encode(), tmp_path / "robot.xacro", arguments={}, find=lambda _: None)
    assert b'name="l10"' in made
    assert ElementTree.canonicalize(made, strip_text=True) == ElementTree.canonicalize(
        xacro.process_file(str(tmp_path / "robot.xacro")).toxml(), strip_text=True
    )


@pytest.mark.parametrize(
    "expression",
    [
        "len('x' * 10**10)",
        "len([0] * 10**10)",
        "'x' * 10**10 if False else [[[0] * 1000] * 1000] * 1000",
        "('x' * 1000).replace('x', 'y' * 100000)",
        "','.join(['x' * 1000] * 100000)",
        "'%10000000000d' % 1",
        "'%*d' % (10**9, 1)",
        "('%(a)s' * 200000) % dict(a='x' * 10**5)",
        "'x'.center(10**10)",
        "list(map(str.center, ['x'], [10**10]))",
        "factorial(10**6)",
        "math.prod(python.range(1, 10**6))",
        "python.sum([[]] * 1000, [0] * 1000)",
        "round(5, -10**9)",
        "list(python.range(10**9))",
        "[x for x in python.range(10**6) for y in python.range(10**6)]",
    ],
)
def test_what_an_expression_would_compute_is_bounded_before_it_is_computed(tmp_path, expression):
    text = f'{HEAD}<xacro:property name="a" value="${{{expression}}}"/><link name="${{a}}"/></robot>'
    (tmp_path / "robot.xacro").write_text(text)
    tracemalloc.start()
    with pytest.raises(UsageError, match="gives a number or a text that is too large"):
        resolved(text.encode(), tmp_path / "robot.xacro", arguments={}, find=lambda _: None)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 50e6


def test_what_is_unpacked_is_bounded_entry_by_entry(monkeypatch):
    monkeypatch.setattr("mjsim.exchange.robots.xacro_bounds.TOTAL", 100)
    endless, bounds = itertools.count(), Bounds()
    code = compile(rewritten(require_harmless("[*islice(a, 200)]")), "<expression>", "eval")
    with pytest.raises(TooLargeError):
        eval(code, {"__builtins__": bounds.names(), "a": endless, "islice": itertools.islice})
    assert next(endless) <= 101


def test_macros_that_double_with_each_other_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("mjsim.exchange.robots.xacro_eval.MOST_MACROS", 200)
    doubling = "".join(
        f'<xacro:macro name="m{k}"><xacro:m{k - 1}/><xacro:m{k - 1}/></xacro:macro>' for k in range(1, 30)
    )
    text = f'{HEAD}<xacro:macro name="m0"><link name="l"/></xacro:macro>{doubling}<xacro:m29/></robot>'
    (tmp_path / "robot.xacro").write_text(text)
    with pytest.raises(UsageError, match="elements of xacro are expanded"):
        resolved(text.encode(), tmp_path / "robot.xacro", arguments={}, find=lambda _: None)
