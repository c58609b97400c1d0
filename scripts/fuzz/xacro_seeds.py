"""Descriptions of robots in xacro with random elements and expressions."""

import random
import re

from changes import Files

HEAD = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">'
DECLARED = (
    '<xacro:arg name="x" default="1"/><xacro:property name="a" value="2.5"/><xacro:property name="k" value="3"/>'
    '<xacro:property name="b" value="${[1, \'ab\', [2]]}"/><xacro:property name="c" value="${dict(a=1, b=dict(a=2))}"/>'
)
PIECES = (
    '<xacro:property name="a" value="${E}"/>',
    '<xacro:macro name="o"><xacro:property name="b" value="E" scope="parent"/></xacro:macro><xacro:o/>${b}',
    '<xacro:property name="c" value="${E}" scope="global" lazy_eval="false"/>',
    '<xacro:property name="d"><link name="${E}"/><xacro:insert_block name="d"/></xacro:property>',
    '<xacro:property name="a" remove="true"/>',
    '<xacro:arg name="x" default="E"/><link name="$(arg x)"/>',
    '<xacro:if value="${E}"><link name="yes ${a}"/></xacro:if><xacro:unless value="E"><link name="no"/></xacro:unless>',
    '<xacro:macro name="m" params="a b:=${E} c:=^|E *p **q"><link name="${a}${b}"/>P<xacro:insert_block name="q"/>'
    '<xacro:insert_block name="p"/></xacro:macro><xacro:m a="${E}"><x>P</x><y>P</y></xacro:m>',
    '<xacro:macro name="n" params="k"><xacro:if value="${k}"><xacro:n k="${k - 1}"/>P</xacro:if></xacro:macro>'
    '<xacro:n k="E"/>',
    '<xacro:call macro="${E}" k="1"/>',
    '<xacro:include filename="part.xacro"/><xacro:include filename="${E}" optional="true"/>',
    '<xacro:include filename="part.xacro" ns="s"/><link name="${s.r}"/><xacro:s.wheel/>',
    '<xacro:element xacro:name="${E}" v="${E}">P</xacro:element>',
    '<link><xacro:attribute name="${E}" value="${E}"/></link>',
    '<link name="${load_yaml(E)}"/>',
    "<link name=\"${load_yaml('sizes.yaml').wheel.E}\"/>",
    '<link name="$(eval E) $(optenv E E) $(find E) $${E} $(E)"/>',
    "<link>${E} text $(arg x) <![CDATA[${E}]]></link>",
)
"""Pieces of a file; E stands for an expression, P for another piece."""
ATOMS = (
    *("0", "1", "-1", "2.5", "1e308", "10**70", "''", "'a'", "'%s'", "'x' * 999", "[]", "[1, 'b']", "True", "None"),
    *("a", "b", "c", "k", "s", "pi", "math", "python", "xacro", "max", "len", "nan", "'../x'", "'sizes.yaml'", "()"),
    *("dict(a=1)", "range(9)", "'\\ud800'", "'\\x00'", "b'a'", "...", "1j", "__import__", "x.__class__", "f'{a}'"),
)
FORMS = (
    *("E + E", "E * E", "E ** E", "E / E", "E % E", "E // E", "E - E", "(E)", "not E", "E and E", "E if E else E"),
    *("E == E", "E in E", "E is E", "E[E]", "E[E:E]", "E.a", "E.pop()", "E.split(E)", "E.replace(E, E)", "E.join(E)"),
    *("[E for x in E]", "[E, E]", "(E, E)", "E(E)", "max(E, E)", "len(E)", "str(E)", "int(E)", "float(E)", "list(E)"),
    *(
        "round(E, E)",
        "sorted(E)",
        "dict(a=E)",
        "dict(E)",
        "map(E, E)",
        "range(E)",
        "math.sqrt(E)",
        "math.E",
        "E &lt;&lt; E",
    ),
    *("python.sum(E)", "python.zip(E, E)", "python.isinstance(E, E)", "xacro.tokenize(E)", "factorial(E)", "lambda: E"),
    *("E &lt; E", "'%d' % E", "E.format(E)", "E.get(E)", "[E for x in E for y in E if E]", "*E", "**E", "E := E"),
)
"""Expressions; E stands for another one."""
YAML = (
    b"wheel: {a: 1, b: [1, 2], E: !degrees 90}\non: yes\n",
    b"&a [*a, *a]\n",
    b"a: &a {x: 1}\nb: {<<: *a}\n",
    b"!!python/object/apply:os.system [ls]\n",
    b"wheel: {a: 1}\n" * 40,
    b"? [1, 2]\n: 3\n",
)


def expression(rng: random.Random, depth: int = 3) -> str:
    """Return a random expression."""
    if depth == 0 or rng.random() < 0.3:
        return rng.choice(ATOMS)
    return re.sub("E", lambda _: expression(rng, depth - 1), rng.choice(FORMS))


def piece(rng: random.Random, depth: int = 2) -> str:
    """Return random elements."""
    text = re.sub(r"\bP\b", lambda _: piece(rng, depth - 1) if depth else "", rng.choice(PIECES))
    return re.sub(r"\bE\b", lambda _: expression(rng), text)


def files_of(rng: random.Random) -> Files:
    """Return a description with random elements of xacro, and the files that it names."""
    body = DECLARED + "".join(piece(rng) for _ in range(rng.randrange(1, 4)))
    part = f'{HEAD}<xacro:property name="r" value="1"/><xacro:macro name="wheel">{piece(rng)}</xacro:macro></robot>'
    return {
        "robot.xacro": f"{HEAD}<group>{body}</group></robot>".encode(),
        "part.xacro": part.encode(),
        "sizes.yaml": rng.choice(YAML),
    }
