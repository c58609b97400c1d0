"""Xacro expands to what the xacro library makes of it: each feature, and formats of numbers."""

# ruff: noqa: E501 - each line is one feature

from collections.abc import Mapping
from pathlib import Path
from xml.etree import ElementTree

import pytest
import xacro
from xacro import substitution_args

from mjsim.errors import UsageError
from mjsim.exchange import RobotOptions, bring_robot
from mjsim.exchange.robots.folders import Folders
from mjsim.models.xacro import Given, parsed, resolved
from tests.exchange.test_robots import typed

HEAD = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">'
FILES = {
    "wheel.xacro": f'{HEAD}<xacro:property name="r" value="0.1"/><xacro:macro name="wheel" params="n">'
    '<link name="${n}" r="${r}"/></xacro:macro><link name="of_the_file"/></robot>',
    "parts/a.xacro": f'{HEAD}<xacro:include filename="b.xacro"/></robot>',
    "parts/b.xacro": f'{HEAD}<link name="b"/></robot>',
    "config/sizes.yaml": "wheel: {radius: 0.1, names: [l, r]}\nturn: !degrees 90\nlength: !millimeters 2*5\nflag: yes\n"
    "none: ~\nbase: &b {x: 1, y: 2}\nother: {<<: *b, y: 3}\nhex: 0x10\nday: 2001-01-02\n",
}
PLAIN = """
<xacro:arg name="namespace" default=""/><xacro:arg name="laser" default="true"/>
<xacro:property name="namespace" value="$(arg namespace)"/><xacro:property name="radius" value="0.04"/>
<xacro:property name="track" value="${2 * radius + 0.1}"/><link name="${namespace}base"/>
<joint name="${namespace}j"><origin xyz="${-track / 2} 0 ${radius * cos(0)}" rpy="${-pi / 2} 0 0"/></joint>
<xacro:if value="$(arg laser)"><link name="laser"/></xacro:if>
<xacro:unless value="$(arg laser)"><link name="no_laser"/></xacro:unless>
<xacro:if value="${radius &gt; 1}"><link name="huge"/></xacro:if>"""
MACRO = '<xacro:macro name="m" params="{}">{}</xacro:macro>{}'
FEATURES = {
    "plain": PLAIN,
    "numbers": "".join(
        f'<a v="${{{text}}}"/>'
        for text in (
            *("1", "1.0", "1e-9", "1/3", "7//2", "-7 % 3", "2**10", "2**-1", "1e22", "1e400", "0x1f", "1 == 1.0", "- -1"),
            *("True", "not 1", "1 if 0 else 2", "0 or 'b'", "1 and 0", "1 &lt; 2 &lt; 3", "5 in [1, 5]", "'a' not in 'b'"),
            *("[1, 'a', (2,)]", "dict(a=1)", "dict(a=1)['a']", "[1, 2, 3][-1]", "'abc'[1:]", "[0] * 3", "'ab' * 2", "()"),
            *("max(1, 2.0)", "min([3, 1])", "len('abc')", "round(2.567, 2)", "round(2.5)", "int('7')", "float('1e3')"),
            *("str(1.50)", "bool('')", "sorted([3, 1, 2])", "list(range(3))", "math.sin(1)", "sin(radians(30))", "pi", "e"),
            *("math.pi", "python.abs(-2)", "python.sum([1, 2])", "python.any([0, 1])", "atan2(1, 2)", "hypot(3, 4)"),
            *("xacro.tokenize('1,2; 3')", "'%.3f and %d' % (1, 2)", "'a b'.split(' ')[1]", "' a '.strip()", "'a'.upper()"),
            *("[x * 2 for x in [1, 2] if x &gt; 1]", "sum if 0 else 1", "list(map(float, ['1', '2']))", "floor(2.7)"),
            *("python.isinstance(1, int)", "python.ord('a')", "factorial(5)", "[1, 2] + [3]", "True + 1"),
            *("'a' + str(2)", "[(k, v) for k, v in dict(a=1).items()]", "fmod(7, 3)", "'-'.join(['a', 'b'])", "3 | 4"),
            *("'x'.replace('x', 'yy')", "degrees(pi)", "dict(a=dict(b=2))['a']['b']", "gcd(12, 18)", "copysign(1, -2)"),
        )
        if "sum if" not in text
    ),
    "literals of properties": "".join(
        f'<xacro:property name="p{k}" value="{text}"/><a v="${{p{k}}}" w="${{p{k}}}x" t="${{p{k} == 1}}"/>'
        for k, text in enumerate(("1", "1.0", "true", "True", " 5 ", "1_000", "'1'", "''", "", "1e3", "nan", "a b", "0 0"))
    ),
    "a text in several parts": '<a v="${1}${2.0}" w=" ${True} " u="x${1 + 1}y"/><b> ${3 * 2} m</b>',
    "dollars": '<a v="$${x}" w="$$(arg x)" u="$$$${x} 5$"/><b>a $ b</b>',
    "lazy properties": '<xacro:property name="a" value="${b + 1}"/><xacro:property name="b" value="1"/><l v="${a}"/>'
    '<xacro:property name="b" value="5"/><l v="${a}"/>',
    "eager properties": '<xacro:property name="b" value="1"/><xacro:property name="a" value="${b + 1}" lazy_eval="false"/>'
    '<xacro:property name="b" value="5"/><l v="${a}"/>',
    "a computed name of a property": '<xacro:property name="${\'a\' + \'b\'}" value="1"/><l v="${ab}"/>',
    "defaults of properties": '<xacro:property name="a" value="1"/><xacro:property name="a" default="2"/>'
    '<xacro:property name="z" default="3"/><l v="${a} ${z}"/>',
    "a property that is removed": '<xacro:property name="a" value="1"/><xacro:property name="a" remove="true"/>'
    '<xacro:property name="a" default="2"/><l v="${a}"/>',
    "scopes": '<xacro:property name="a" value="1"/><xacro:property name="z" value="0"/>'
    + MACRO.format(
        "",
        '<xacro:property name="a" value="2"/><xacro:property name="z" value="${a}" scope="parent"/>'
        '<xacro:property name="g" value="${a + 1}" scope="global"/><l v="${a}"/>',
        '<xacro:m/><l v="${a} ${z} ${g}"/>',
    ),
    "a property of a block": '<xacro:property name="o"><origin xyz="${v} 0 0"/><b/></xacro:property>'
    '<xacro:property name="v" value="3"/><l><xacro:insert_block name="o"/></l>',
    "arguments": '<xacro:arg name="a" default="${1 + 1}"/><xacro:arg name="a" default="9"/><l v="$(arg a)x ${xacro.arg(\'a\')}"/>',
    "an argument within an expression": '<xacro:arg name="a" default="2"/><l v="${$(arg a) + 1}"/>',
    "conditions": "".join(
        f'<xacro:if value="{text}"><y v="{k}"/></xacro:if><xacro:unless value="{text}"><n v="{k}"/></xacro:unless>'
        for k, text in enumerate(("1", "0", "true", "False", "${1 &gt; 2}", "${[]}", "${\'true\'}", "2", "${0.5}"))
    ),
    "an unless in an if": '<xacro:if value="1"><xacro:unless value="0"><l/></xacro:unless></xacro:if>',
    "parameters": MACRO.format("a b:=2 c:='x y' d=4", '<l v="${a} ${b} ${c} ${d}"/>', '<xacro:m a="1"/><xacro:m a="${1}" b="0" d="z"/>'),
    "forwarded parameters": '<xacro:property name="a" value="7"/>'
    + MACRO.format("a:=^ b:=^|5 c:=^|${a+1}", '<l v="${a} ${b} ${c}"/>', '<xacro:m/><xacro:property name="b" value="6"/><xacro:m a="1"/>'),
    "a default that is an expression": MACRO.format("a b:=${a_0} c:=$(arg q)", '<l v="${a} ${b} ${c}"/>',
        '<xacro:arg name="q" default="8"/><xacro:property name="a_0" value="3"/><xacro:m a="1"/>'),
    "a default with quotes": MACRO.format("a:='' b:='0 0 0' c:=&quot;1 2&quot;", '<l v="${a}|${b}|${c}"/>', "<xacro:m/>"),
    "a block": MACRO.format("*o n", '<l><xacro:insert_block name="o"/>${n}</l>', '<xacro:m n="1"><origin xyz="${1 + 1}"/></xacro:m>'),
    "the content of a block": MACRO.format("**o", '<l><xacro:insert_block name="o"/></l>', '<xacro:m><x><a/><b v="${2}"/></x></xacro:m>'),
    "two blocks, inserted twice": MACRO.format("*a **b", '<xacro:insert_block name="b"/><xacro:insert_block name="a"/><xacro:insert_block name="a"/>',
        "<xacro:m><p/><q><r/></q></xacro:m>"),
    "a macro in a block": '<xacro:macro name="i"><deep/></xacro:macro>'
    + MACRO.format("*a", '<l><xacro:insert_block name="a"/></l>', "<xacro:m><p><xacro:i/></p></xacro:m>"),
    "a macro in a macro": MACRO.format("k", '<l v="${k}"/><xacro:if value="${k &gt; 0}"><xacro:m k="${k - 1}"/></xacro:if>', '<xacro:m k="9"/>'),
    "a macro of a macro": MACRO.format("", '<xacro:macro name="inner"><x/></xacro:macro><xacro:inner/>', "<xacro:m/>"),
    "a macro that is redefined": MACRO.format("", "<a/>", "<xacro:m/>") + MACRO.format("b", '<b v="${b}"/>', '<xacro:m b="1"/>'),
    "a call by name": MACRO.format("a", '<l v="${a}"/>', '<xacro:property name="n" value="m"/><xacro:call macro="${n}" a="2"/>'),
    "a name with the prefix": '<xacro:macro name="xacro:m"><l/></xacro:macro><xacro:m/>',
    "dynamic scope": MACRO.format("", '<l v="${outside}"/>', '<xacro:macro name="n" params="outside"><xacro:m/></xacro:macro><xacro:n outside="4"/>'),
    "an element by name": '<xacro:element xacro:name="${\'li\' + \'nk\'}" name="${1}"><a v="${2}"/></xacro:element>',
    "a macro by an element's name": MACRO.format("a", '<l v="${a}"/>', '<xacro:element xacro:name="xacro:m" a="3"/>'),
    "an attribute by name": '<l><xacro:attribute name="${\'a\' + \'b\'}" value="${1 + 1} 0"/><x/></l>',
    "attributes of xacro": '<l xacro:note="gone" kept="${1}"/>',
    "an include": '<xacro:include filename="wheel.xacro"/><xacro:wheel n="w"/><l v="${r}"/>',
    "an include in a namespace": '<xacro:include filename="wheel.xacro" ns="w"/><xacro:w.wheel n="a"/><l v="${w.r}"/>',
    "an include of an include": '<xacro:include filename="parts/a.xacro"/>',
    "an include of a pattern": '<xacro:include filename="parts/[b-z]*.xacro"/>',
    "an include that may be missing": '<xacro:include filename="none.xacro" optional="true"/><l/>',
    "an include of a package": '<xacro:include filename="$(find mine)/wheel.xacro"/><xacro:wheel n="w"/>',
    "a mesh of a package": '<mesh filename="package://mine/a.stl"/><mesh filename="file://$(find mine)/a.stl"/>',
    "YAML": '<xacro:property name="s" value="${xacro.load_yaml(\'config/sizes.yaml\')}"/>'
    '<l v="${s.wheel.radius} ${s[\'wheel\'][\'names\'][0]} ${s.turn} ${s.length} ${s.flag} ${s.none} ${s.other}"/>'
    '<l v="${s.hex} ${s.day} ${len(s)} ${\'on\' in s} ${s.get(\'gone\', 5)} ${[k for k in s.keys()]}"/>',
    "YAML of a package": "<l v=\"${load_yaml('$(find mine)/config/sizes.yaml')['hex']}\"/>",
    "an optional variable": '<l v="$(optenv NOT_SET 1 2 3)|$(optenv NOT_SET)"/>',
    "an eval": '<xacro:arg name="a" default="2"/><l v="$(eval a + 1) $(eval a == 2) $(eval 1.5 * 2)"/>',
    "messages": "<l v=\"${xacro.warning('careful')}\"/>",
    "comments and sections": "<l><!-- ${gone} --><![CDATA[${gone} <b>]]></l>",
    "entities": '<l v="&lt;&amp;&quot;&#36;{1}">&lt;${1}&gt;</l>',
    "other namespaces": '<g xmlns:o="http://o"><o:a o:b="${1}"/></g>' + MACRO.format("", "<q/>", "<xacro:m/>"),
    "names of xacro's own": '<xacro:property name="length" value="2"/><xacro:property name="e" value="3"/><l v="${length * e}"/>',
    "a list that shrinks": '<xacro:property name="q" value="${[1, 2, 3]}"/><l v="${q.pop(0)} ${q.pop()} ${q}"/>',
}  # fmt: skip


def laid_out(folder: Path, body: str) -> Path:
    """Write a description with its files, and return its path."""
    for name, text in {**FILES, "robot.xacro": f"{HEAD}<group>{body}</group></robot>"}.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    return folder / "robot.xacro"


def expanded(path: Path, *, packages: Mapping[str, Path] | None = None, **given: str) -> str:
    """Return what mjsim makes of a description."""
    path = path.resolve()
    text, _ = parsed(path.read_bytes(), path)
    folders = Folders(path, packages or {})
    return resolved(text, path, shown=path, given=Given(given, {}), files=folders).text


def canonical(text: str) -> str:
    """Return XML that is the same for the same content."""
    return ElementTree.canonicalize(text, strip_text=True, rewrite_prefixes=True)


@pytest.mark.parametrize("feature", FEATURES)
def test_a_feature_of_xacro_gives_what_the_library_gives(tmp_path, monkeypatch, feature):
    place = laid_out(tmp_path, FEATURES[feature])
    monkeypatch.setattr(substitution_args, "_eval_find", lambda name: f"package://{name}")
    monkeypatch.setattr(xacro, "abs_filename_spec", opened_like_ours(tmp_path, xacro.abs_filename_spec))
    theirs = xacro.process_file(str(place)).toxml().replace("file://package://", "package://")
    assert canonical(expanded(place, packages={"mine": tmp_path})) == canonical(theirs)


def opened_like_ours(folder, before):
    """Return the library's function for paths, which knows the package `mine`."""
    return lambda name: name.replace("package://mine", str(folder)) if name.startswith("package:") else before(name)


@pytest.mark.parametrize("arguments", [{}, {"namespace": "a_"}, {"laser": "false"}])
def test_arguments_of_the_user_go_before_those_of_the_file(tmp_path, arguments):
    place = laid_out(tmp_path, PLAIN)
    theirs = xacro.process_file(str(place), mappings=dict(arguments)).toxml()
    assert canonical(expanded(place, **arguments)) == canonical(theirs)


def test_a_namespace_that_nobody_declared_is_empty_or_what_is_given(tmp_path):
    place = laid_out(tmp_path, '<link name="${namespace}base"/>')
    for arguments, base in (({}, "base"), ({"namespace": "a_"}, "a_base")):
        assert ElementTree.fromstring(expanded(place, **arguments)).find(".//link").get("name") == base


def test_a_prefix_of_any_name_is_xacros_where_it_is_declared_so(tmp_path):
    place = laid_out(tmp_path, "")
    place.write_text(
        '<robot xmlns:x="http://ros.org/wiki/xacro"><x:property name="a" value="2"/><link v="${a}"/></robot>'
    )
    assert canonical(expanded(place)) == canonical('<robot><link v="2"/></robot>')


def test_a_file_without_xacro_stays_as_it_is(tmp_path):
    place = laid_out(tmp_path, "")
    place.write_text('<robot  name="a"><!-- xacro -->\n</robot >')
    assert expanded(place) == place.read_text()


@pytest.mark.parametrize(
    ("body", "what"),
    [
        ('<xacro:property name="a" value="${b}"/><xacro:property name="b" value="${a}"/><l v="${a}"/>',
         r":1:\d+: the property 'a' refers to itself \(a -> b -> a\)"),
        ('<xacro:property name="wheel" value="1"/>\n <l v="${whel}"/>', r":2:2: no xacro:property 'whel'; did you mean 'wheel'"),
        ('<link name="${gone}"/>', r"no xacro:property 'gone'; declare it, or give --arg gone=VALUE"),
        ("<xacro:nothing/>", "no macro is called 'nothing'"),
        ('<xacro:macro name="whel"/><xacro:wheel/>', "no macro is called 'wheel'; did you mean 'whel'"),
        ('<xacro:include filename="$(find far)/x.xacro"/>', "names the package 'far', which was not found; give --package far=DIR"),
        ('<l v="$(arg size)"/>', "xacro:arg 'size' has no value; give --arg size=VALUE"),
        ('<xacro:macro name="m"/><l v="$(arg size)"/>', "xacro:arg 'size' has no value; give --arg size=VALUE"),
        ('<l v="$(env HOME)"/>', r"\$\(env HOME\) is not read from your environment; give --env HOME=VALUE"),
        ('<l v="$(arh size)"/>', r"\$\(arh size\) is not known; did you mean 'arg'"),
        ('<l v="$(arg a b)"/>', "too many or too few words"),
        ('<l v="${1 +}"/>', r"'1 \+' is not an expression; correct it"),
        ('<l v="${1; 2}"/>', "is not an expression"),
        ('<l v="${1 / 0}"/>', r"'1 / 0' cannot be computed \(division by zero\); correct it"),
        ('<l v="${\'a\' + 1}"/>', "cannot be computed"),
        ('<l v="${dict(a=1).b}"/>', "there is no 'b' in this dict; there are a"),
        ('<l v="$$$"/>', "write .* for a dollar"),
        ('<xacro:if value="maybe"><l/></xacro:if>', "the condition 'maybe' is 'maybe'; it must be true or false"),
        ('<xacro:if><l/></xacro:if>', "has no 'value'; add it"),
        ('<xacro:property name="1a" value="1"/>', "a property cannot be called '1a'"),
        ('<xacro:property name="a" value="1" scope="parent"/>', "is for properties of macros"),
        ('<xacro:macro name="m" params="a"/><xacro:m/>', "the macro needs the parameter 'a'"),
        ('<xacro:macro name="m" params="a"/><xacro:m a="1" c="2"/>', "the macro has no parameter 'c'"),
        ('<xacro:macro name="m" params="*a"/><xacro:m/>', "the macro takes 1 blocks, but gets 0"),
        ('<xacro:macro name="m" params="a:=^"/><xacro:m/>', "the macro needs the parameter 'a'"),
        ('<xacro:macro name="call"/>', "a macro cannot be called 'call'"),
        ('<l><xacro:insert_block name="b"/></l>', "there is no block 'b'"),
        ('<xacro:element xacro:name="a b"/>', "'a b' is not a name in XML"),
        ("<l v=\"${xacro.fatal('no', 3)}\"/>", "the file says: no 3"),
        ("<l v=\"${load_yaml('bad.yaml')}\"/>", r"bad\.yaml:2:2 is not YAML of plain values"),
    ],
)  # fmt: skip
def test_what_is_wrong_in_xacro_is_one_line_with_its_place(tmp_path, body, what):
    place = laid_out(tmp_path, body)
    (tmp_path / "bad.yaml").write_text("a: [1\nb: }")
    with pytest.raises(UsageError, match=what) as caught:
        expanded(place)
    assert str(caught.value).startswith(f"{place}:")
    assert len(str(caught.value).splitlines()) == 1


def test_an_error_in_an_included_file_has_its_place(tmp_path):
    place = laid_out(tmp_path, '<xacro:include filename="parts/c.xacro"/>')
    (tmp_path / "parts" / "c.xacro").write_text(f"{HEAD}\n\n  <l v='${{gone}}'/></robot>")
    with pytest.raises(UsageError, match=r"parts/c\.xacro:3:3: no xacro:property 'gone'"):
        expanded(place)


@pytest.mark.slow
def test_macros_are_expanded_and_packages_found(tmp_path):
    place = tmp_path / "r.urdf.xacro"
    place.write_text(ROBOT)
    (tmp_path / "mine").mkdir()
    brought = bring_robot(place, name="r", options=RobotOptions(), packages={"mine": tmp_path / "mine"}, arguments={})
    assert "left out: 2 missing meshes 'tyre.stl': collision shapes are used instead" in brought.report
    assert 'left: {joint: "left_joint"' in brought.text


@pytest.mark.slow
def test_the_command_gives_variables_to_a_file(tmp_path, monkeypatch):
    monkeypatch.setenv("SIDE", "of the environment")
    place = tmp_path / "r.urdf.xacro"
    place.write_text(ROBOT.replace('"left"', '"$(env SIDE)"'))
    code, said = typed("new", "--robot-from", str(place), "-o", str(tmp_path / "o.yaml"), "--env", "SIDE")
    assert (code, said) == (2, "'SIDE' is not NAME=VALUE; write --env NAME=VALUE\n")
    code, said = typed("new", "--robot-from", str(place), "-o", str(tmp_path / "o.yaml"))
    assert code == 2
    assert said.endswith("give --env SIDE=VALUE\n")
    code, said = typed("new", "--robot-from", str(place), "-o", str(tmp_path / "o.yaml"), "--env", "SIDE=port")
    assert code == 0, said
    assert "port_joint" in (tmp_path / "o.yaml").read_text()


ROBOT = f"""{HEAD}
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
