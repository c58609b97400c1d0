"""What a stranger's xacro file tries beyond describing a robot is refused in one line: nothing runs, nothing is read."""

# ruff: noqa: E501 - each line is one attempt

import codecs
import os
import time
import tracemalloc
from pathlib import Path

import pytest
import yaml

from mjsim.errors import UsageError
from mjsim.exchange.robots.folders import Folders
from mjsim.models.xacro import budget
from tests.exchange.test_xacro import HEAD, expanded

SECRET = "canary-5e2f"
GLOBALS = "[c for c in x.__class__.__base__.__subclasses__() if c.__name__ == '_wrap_close'][0].__init__.__globals__"
RUN = "['system']('touch ran')"
EXPRESSIONS = {
    "the exploit of a reporter": "[V(T(d))['__get__'](d,f)['system']('touch ran') for V in [python.vars] for T in [python.type] for c in V(T)['__subclasses__'](V(T)['mro'](int)[1]) if '_wrap_close' in str(c) for f in [V(c)['__init__']] for d in [V(T(f))['__globals__']]]",
    "attributes in a comprehension": f"[{GLOBALS}{RUN} for x in [()]]",
    "attributes of a number": "(1).__class__",
    "attributes of a function": "math.sin.__self__",
    "attributes of a module": "math.__loader__.load_module('os').system('touch ran')",
    "attributes of a namespace": "xacro.__class__.__init__.__globals__",
    "attributes of a function's method": "'a'.upper.__self__",
    "attributes of a list": "[].append.__self__",
    "a subscript of a module": "math['sin']",
    "a subscript of a function": "max['__globals__']",
    "a format": "'{0.__class__}'.format(1)",
    "a format with %": "'%(__class__)s' % 1",
    "a format string": "f'{().__class__}'",
    "vars": "python.vars(math)",
    "type": "python.type(1)",
    "getattr": "getattr(1, 'real')",
    "import": "__import__('os').system('touch ran')",
    "builtins": "__builtins__['eval']('1')",
    "eval": "eval('1')",
    "open": "open('/etc/passwd').read()",
    "a lambda": "(lambda: 1)()",
    "a generator's frame": "[g.gi_frame for g in [(x for x in [])]]",
    "an assignment": "(a := 1)",
    "unpacking": "[*[1, 2]]",
    "unpacking of names": "dict(**dict(a=1))",
    "await": "await 1",
    "bytes": "b'a'",
    "a function as a value": "max",
    "a module as a value": "math",
    "functions in a list": "[max][0](1, 2)",
    "a function by a choice": "(max if 1 else min)(1, 2)",
    "a function given to a function": "str(max)",
    "a method as a value": "'a'.upper",
    "a map of methods": "list(map(str.center, ['x'], [10]))",
    "a map of a map": "list(map(map, [1], [2]))",
    "sorting by a function": "sorted([1], key=max)",
    "a kind that is no kind": "python.isinstance(1, 'int')",
    "messages to a file": "xacro.message('x', file=1).y",
    "a shift": "1 &lt;&lt; 10000000000",
    "a matrix product": "1 @ 2",
    "a set of a set": "{1} if 0 else 1j",
    "a text that is half a character": "'\\ud800'",
    "the name of the file's loader": "load_yaml.__globals__",
}
LARGE = (
    "9**9**9", "2**100000", "(10**70)*(10**70)", "10.0**400", "factorial(10**6)", "comb(10**6, 10**5)", "math.perm(10**7)",
    "'x' * 10**9", "10**9 * 'x'", "[0] * 10**9", "len('x' * 10**10)", "[[[0] * 1000] * 1000] * 1000", "'x' * 1000001",
    "('x' * 1000).replace('x', 'y' * 100000)", "','.join(['x' * 1000] * 100000)", "('x' * 1000).join(['y'] * 10000)",
    "'%10000000000d' % 1", "'%*d' % (10**9, 1)", "('%(a)s' * 20000) % dict(a='x' * 10**4)", "'%.999999999f' % 1.5",
    "'x'.center(10**10)", "'x'.ljust(10**10)", "'x'.zfill(10**10)", "'\t'.expandtabs(10**10)", "round(5, -10**9)",
    "list(python.range(10**9))", "[x for x in python.range(10**5) for y in python.range(10**5)]", "lcm(*range(99))",
    "list(map(range, [99999] * 1000))", "python.sum([[]] * 1000, [0] * 1000)", "math.prod(range(1, 10**5))",
    "int('9' * 5000)", "str([['x' * 1000] * 99] * 99)", "-" * 3000 + "1", "(" * 2000 + "1" + ")" * 2000, "[" * 400 + "]" * 400,
    "1" + "+1" * 1900, "'a' not in [['b' * 99999] * 9]",
)  # fmt: skip
CANARY = "canary/secret"
BODIES = {
    "an include of an absolute path": '<xacro:include filename="{out}/secret.xacro"/>',
    "an include from above": '<xacro:include filename="../canary/secret.xacro"/>',
    "an include by a link": '<xacro:include filename="link.xacro"/>',
    "an include by a link of a folder": '<xacro:include filename="links/secret.xacro"/>',
    "an include by a pattern": '<xacro:include filename="links/*.xacro"/>',
    "an include by a pattern from above": '<xacro:include filename="../canary/*.xacro"/>',
    "an include by a pattern with a way up": '<xacro:include filename="[l]inks/../../canary/*.xacro"/>',
    "an include in a namespace": '<xacro:include filename="../canary/secret.xacro" ns="n"/>',
    "an include that may be missing": '<xacro:include filename="../canary/secret.xacro" optional="true"/>',
    "an include by a computed name": "<xacro:include filename=\"${{'..' + '/canary/'}}secret.xacro\"/>",
    "an include by the folder": '<xacro:include filename="$(dirname)/../canary/secret.xacro"/>',
    "an include of the process": '<xacro:include filename="/proc/self/environ"/>',
    "an include of a URI": '<xacro:include filename="file://{out}/secret.xacro"/>',
    "a package of the system": '<xacro:include filename="$(find etc)/hostname"/>',
    "a package beside": '<xacro:include filename="$(find canary)/secret.xacro"/>',
    "a package around": '<xacro:include filename="$(find {above})/canary/secret.xacro"/>',
    "a package above": '<xacro:include filename="$(find ..)/canary/secret.xacro"/>',
    "a package by a path": '<xacro:include filename="$(find mine/../canary)/secret.xacro"/>',
    "a way out of a package": '<xacro:include filename="$(find mine)/../canary/secret.xacro"/>',
    "a package in a URI": '<xacro:include filename="package://../canary/secret.xacro"/>',
    "a null character": "<xacro:include filename=\"${{xacro.load_yaml('null.yaml')}}\"/>",
    "YAML of an absolute path": "<l v=\"${{xacro.load_yaml('{out}/secret.yaml')}}\"/>",
    "YAML from above": "<l v=\"${{load_yaml('../canary/secret.yaml')}}\"/>",
    "YAML by a link": "<l v=\"${{load_yaml('link.yaml')}}\"/>",
    "YAML of the process": "<l v=\"${{load_yaml('/proc/self/environ')}}\"/>",
    "YAML of a package": "<l v=\"${{load_yaml('$(find canary)/secret.yaml')}}\"/>",
    "YAML by an absolute name": "<l v=\"${{load_yaml(xacro.abs_filename('../canary/secret.yaml'))}}\"/>",
    "YAML of a pipe": "<l v=\"${{load_yaml('pipe')}}\"/>",
    "an include of a pipe": '<xacro:include filename="pipe"/>',
    "an include of a folder": '<xacro:include filename="links"/>',
    "a variable": '<l v="$(env CANARY)"/>',
    "a variable by a default": '<xacro:arg name="a" default="$(env CANARY)"/><l v="$(arg a)"/>',
    "a variable in an eval": '<l v="$(eval env)"/>',
    "the working folder": '<l v="$(cwd)"/>',
    "a substitution in a substitution": '<xacro:arg name="a" default="$$(env CANARY)"/><l v="${{$(arg a)}}"/>',
    "YAML with an object": "<l v=\"${{load_yaml('object.yaml')}}\"/>",
    "YAML with a name": "<l v=\"${{load_yaml('name.yaml')}}\"/>",
    "YAML with an expression": "<l v=\"${{load_yaml('unit.yaml')}}\"/>",
    "an entity": '<xacro:include filename="entity.xacro"/>',
    "an entity in UTF-16": '<xacro:include filename="entity16.xacro"/>',
    "an entity in UTF-7": '<xacro:include filename="entity7.xacro"/>',
    "an XInclude": '<xi:include xmlns:xi="http://www.w3.org/2001/XInclude" href="{out}/secret.xacro" parse="text"/><l v="${{gone}}"/>',
    "a property with two underscores": '<xacro:property name="__class__" value="1"/>',
    "a property in the place of a function": '<xacro:property name="max" value="1"/><l v="${{max(1, 2)}}"/>',
    "a macro that calls itself": '<xacro:macro name="m"><xacro:m/></xacro:macro><xacro:m/>',
    "a macro with an odd name that calls itself": '<xacro:macro name="__x"><xacro:__x/></xacro:macro><xacro:__x/>',
    "a block that inserts itself": '<xacro:property name="b"><x><xacro:insert_block name="b"/></x></xacro:property><xacro:insert_block name="b"/>',
    "a block of a macro that inserts itself": '<xacro:macro name="m" params="**b"><xacro:m><xacro:insert_block name="b"/><y/></xacro:m></xacro:macro><xacro:m><x/></xacro:m>',
    "a call by name of itself": '<xacro:macro name="m"><xacro:call macro="m"/></xacro:macro><xacro:call macro="m"/>',
    "an element that is itself": '<xacro:element xacro:name="xacro:element"/>',
    "an include of itself": '<xacro:include filename="robot.xacro"/>',
    "a prefix of its own": '<x:include xmlns:x="http://ros.org/xacro" filename="../canary/secret.xacro"/>',
    "properties one of the next": "".join(f'<xacro:property name="p{k}" value="${{{{p{k + 1}}}}}"/>' for k in range(400)) + '<l v="${{p0}}"/>',
    "lists that grow in a loop": '<xacro:property name="a" value="${{[1]}}"/><xacro:macro name="m"><xacro:property name="a" value="${{a + a}}" scope="global"/><xacro:m/></xacro:macro><xacro:m/>',
    "text that grows in a loop": '<xacro:property name="a" value="ab"/><xacro:macro name="m"><xacro:property name="a" value="${{a}}${{a}}" scope="global"/><xacro:m/></xacro:macro><xacro:m/>',
    "arguments that grow": '<xacro:arg name="a0" default="ab"/>' + "".join(f'<xacro:arg name="a{k + 1}" default="{f"$(arg a{k})" * 10}"/>' for k in range(9)),
    "aliases that multiply": "<l v=\"${{load_yaml('laughs.yaml')}}\"/>",
    "merges that multiply": "<l v=\"${{load_yaml('merges.yaml')}}\"/>",
    "an alias of itself": "<l v=\"${{load_yaml('loop.yaml')}}\"/>",
    "deep YAML": "<l v=\"${{load_yaml('deep.yaml')}}\"/>",
    "long YAML": "<l v=\"${{load_yaml('long.yaml')}}\"/>",
    "a file read over and over": '<xacro:macro name="m" params="k"><xacro:property name="y" value="${{load_yaml(\'remarks.yaml\')}}" lazy_eval="false"/></xacro:macro>' + '<xacro:m k="1"/>' * 400,
    "deep elements": "<a>" * 150 + "</a>" * 150,
    "a pattern of many folders": '<xacro:include filename="here/*/here/*.xacro"/>',
    "an included file that is no XML": '<xacro:include filename="deep.yaml"/>',
    "a namespace in the place of a block": '<xacro:include filename="here/part.xacro" ns="**b"/><xacro:insert_block name="b"/>',
    "a name of two lines": "<xacro:call macro=\"${{'a\\nb\\x1b[31m'}}\"/>",
    "half a character in a path": "<l v=\"${{load_yaml('\\ud800')}}\"/>",
    "half a character in a name": "<xacro:call macro=\"${{'\\ud800'}}\"/>",
    "half a character in YAML": "<l v=\"${{load_yaml('half.yaml')}}\"/>",
    "a null character in a path": "<l v=\"${{load_yaml('a\\0')}}\"/>",
    "long names that are alike": "".join(f'<xacro:property name="{"a" * 9000}{k}" value="1"/>' for k in range(99)) + f'<l v="${{{{{"a" * 3900}}}}}"/>',
    "a long name of a file": '<xacro:include filename="' + "x" * 300 + '" optional="true"/><l v="${{gone}}"/>',
    "a long name of a package": '<xacro:include filename="$(find ' + "x" * 300 + ')/x" optional="true"/><l v="${{gone}}"/>',
    "an odd name of an element": '<xacro:element xacro:name="a&gt;&lt;!DOCTYPE x"/>',
    "an odd name of an attribute": '<l><xacro:attribute name="a=&quot;1&quot; b" value="2"/></l>',
    "parameters without end": f'<xacro:macro name="m" params="{"a " * 300}"/>',
}  # fmt: skip
ALIASES = "".join(f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 9)}]\n" for k in range(1, 12))
MERGES = "".join(f"a{k}: &a{k} {{<<: [{', '.join([f'*a{k - 1}'] * 9)}]}}\n" for k in range(1, 12))
ENTITY = '<!DOCTYPE robot [<!ENTITY s SYSTEM "{}">]><robot name="&s;"/>'


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Return the folder of a stranger's robot, beside which there is a secret."""
    out, own = tmp_path / "canary", tmp_path / "robot"
    out.mkdir()
    own.mkdir()
    (out / "secret.xacro").write_text(f'{HEAD}<link name="{SECRET}"/></robot>')
    (out / "secret.yaml").write_text(f"{{secret: {SECRET}}}")
    (own / "here").symlink_to(own)
    (own / "part.xacro").write_text(f"{HEAD}</robot>")
    (own / "link.xacro").symlink_to(out / "secret.xacro")
    (own / "link.yaml").symlink_to(out / "secret.yaml")
    (own / "links").symlink_to(out)
    os.mkfifo(own / "pipe")
    entity = ENTITY.format(f"file://{out}/secret.yaml")
    texts = {
        "object.yaml": "!!python/object/apply:os.system ['touch ran']",
        "name.yaml": "!!python/name:os.system",
        "unit.yaml": "!degrees \"__import__('os').system('touch ran')\"",
        "null.yaml": '"a\\0b"',
        "laughs.yaml": f"a0: &a0 [1, 2]\n{ALIASES}",
        "merges.yaml": f"a0: &a0 {{x: 1}}\n{MERGES}",
        "loop.yaml": "&a [*a]",
        "remarks.yaml": "# nothing\n" * 10_000,
        "half.yaml": '"\\ud800"',
        "deep.yaml": "[" * 1000,
        "long.yaml": "- 1\n" * 100_000,
        "entity.xacro": entity,
        "entity7.xacro": '<?xml version="1.0" encoding="utf-7"?>' + entity.encode("utf-7").decode(),
    }
    for name, text in texts.items():
        (own / name).write_text(text)
    (own / "entity16.xacro").write_bytes(codecs.BOM_UTF16_LE + entity.encode("utf-16-le"))
    monkeypatch.setattr(budget, "STEPS", 60_000)
    monkeypatch.setenv("CANARY", SECRET)
    monkeypatch.chdir(own)
    return own


def refused(folder: Path, body: str) -> str:
    """Return the line in which a description is refused; nothing has been run, read or made in its place."""
    place = folder / "robot.xacro"
    place.write_text(f"{HEAD}<group>{body}</group></robot>")
    before = sorted(folder.iterdir())
    start = time.process_time()
    with pytest.raises(UsageError) as caught:
        expanded(place, packages={"mine": folder})
    assert time.process_time() - start < 10.0
    said = str(caught.value)
    assert said.isprintable()
    assert len(said) < 700
    assert SECRET not in said
    assert sorted(folder.iterdir()) == before
    return said


@pytest.mark.parametrize("attempt", EXPRESSIONS)
def test_an_expression_does_nothing_but_compute(folder, attempt):
    assert "; " in refused(
        folder, f'<xacro:property name="a" value="${{{EXPRESSIONS[attempt]}}}"/><link name="${{a}}"/>'
    )


@pytest.mark.parametrize("attempt", BODIES)
def test_a_file_reaches_nothing_outside_of_its_folder(folder, attempt):
    refused(folder, BODIES[attempt].format(out=folder.parent / "canary", above=folder.parent.name))


@pytest.mark.parametrize("expression", LARGE)
def test_what_an_expression_would_compute_is_bounded_before_it_is_computed(folder, expression):
    tracemalloc.start()
    refused(folder, f'<xacro:property name="a" value="${{{expression}}}"/><link name="${{a}}"/>')
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 50e6


@pytest.mark.slow
@pytest.mark.parametrize("attempt", ["aliases that multiply", "merges that multiply", "a macro that calls itself"])
def test_the_longest_work_ends_within_seconds(folder, monkeypatch, attempt):
    monkeypatch.undo()
    refused(folder, BODIES[attempt].format(out=folder.parent / "canary", above=folder.parent.name))


def test_macros_that_double_with_each_other_are_refused(folder):
    doubling = "".join(
        f'<xacro:macro name="m{k}"><xacro:m{k - 1}/><xacro:m{k - 1}/></xacro:macro>' for k in range(1, 30)
    )
    said = refused(folder, f'<xacro:macro name="m0"><link name="l"/></xacro:macro>{doubling}<xacro:m29/>')
    assert "it takes more than 60000 steps to expand; make it simpler" in said


def test_a_macro_may_call_itself_eighty_times(folder):
    place = folder / "robot.xacro"
    turn = '<l v="${k}"/><xacro:if value="${k}"><xacro:m k="${k - 1}"/></xacro:if>'
    place.write_text(
        f'{HEAD}<group><xacro:macro name="m" params="k">{turn}</xacro:macro><xacro:m k="80"/></group></robot>'
    )
    assert expanded(place).count("<l ") == 81


def test_the_library_for_yaml_makes_objects_only_where_it_is_told_to(folder):
    with pytest.raises(yaml.YAMLError):
        yaml.safe_load((folder / "object.yaml").read_text())


def nested_calls(depth, work):
    """Call a function from so deep in others."""
    return work() if depth == 0 else nested_calls(depth - 1, work)


def test_a_deep_file_is_refused_however_deep_the_caller_is(folder):
    body = "".join(f'<xacro:property name="p{k}" value="${{[[p{k + 1}]]}}"/>' for k in range(400)) + '<l v="${p0}"/>'
    for depth in (0, 300, 600):
        assert "nested too deeply" in nested_calls(depth, lambda: refused(folder, body))


@pytest.mark.parametrize("name", ["link.yaml", "links/secret.yaml", "../canary/secret.yaml", "pipe", "links", "gone"])
def test_no_reader_of_a_robots_files_gets_what_lies_outside(folder, name):
    with pytest.raises(ValueError, match=r"lies outside|cannot be read: .*; name|no file"):
        Folders(folder / "robot.xacro", {}).read(folder / name)


def test_folders_named_by_the_user_are_open_and_those_found_look_like_packages(folder):
    folders = Folders(folder / "robot.xacro", {"given": folder.parent / "canary"})
    assert SECRET in folders.read(folder.parent / "canary" / "secret.yaml").decode()
    found = Folders(folder / "robot.xacro", {})
    assert found.package("canary") is None
    (folder.parent / "canary" / "package.xml").touch()
    assert found.package("canary") == folder.parent / "canary"


def test_an_optional_variable_has_its_default_whatever_the_environment_says(folder):
    place = folder / "robot.xacro"
    place.write_text(f'{HEAD}<group><l v="$(optenv CANARY none)"/></group></robot>')
    assert '<l v="none">' in expanded(place)
