"""Expand broken and odd xacro files by the thousand: each must give text, or be refused in one line.

python scripts/fuzz/xacro_inputs.py [--inputs 100000] [--seed 1]

`files_of` makes the files of one input: elements of xacro with random expressions, of which values, names, bytes and
pieces are changed. The first input that ends otherwise, or takes longer than a limit, is written to out/fuzz and ends
the script with exit code 1.
"""

import argparse
import random
import re
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Mapping
from pathlib import Path

from mjsim.errors import UsageError
from mjsim.exchange.robots.folders import Folders
from mjsim.exchange.robots.xacro import Given, parsed, resolved

LIMIT = 15.0
"""No input may take longer, on a busy machine [s of processor time]."""
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
WILD = (
    b"",
    b"$",
    b"${",
    b"$(",
    b"}",
    b")",
    b"&amp;",
    b"&x;",
    b"<!DOCTYPE a>",
    b"<x>",
    b"</x>",
    b"\xff",
    b"\x00",
    b"'",
    b'"',
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


def changed(data: bytes, rng: random.Random) -> bytes:
    """Return bytes of which some are replaced, left out or repeated."""
    for _ in range(rng.choice((0, 0, 0, 0, 0, 1, 3))):
        start = rng.randrange(len(data) + 1)
        end = min(len(data), start + rng.choice((0, 1, 1, 8, 64)))
        data = data[:start] + rng.choice((*WILD, data[start:end] * 2)) + data[end:]
    return data


def files_of(rng: random.Random) -> Mapping[str, bytes]:
    """Return the files of an input by name; `robot.xacro` is the description."""
    body = DECLARED + "".join(piece(rng) for _ in range(rng.randrange(1, 4)))
    part = f'{HEAD}<xacro:property name="r" value="1"/><xacro:macro name="wheel">{piece(rng)}</xacro:macro></robot>'
    return {
        "robot.xacro": changed(f"{HEAD}<group>{body}</group></robot>".encode(), rng),
        "part.xacro": changed(part.encode(), rng),
        "sizes.yaml": changed(rng.choice(YAML), rng),
    }


def outcome(folder: Path, files: Mapping[str, bytes]) -> str:
    """Return how an input ends: expanded, or the message without what varies."""
    for name, data in files.items():
        (folder / name).write_bytes(data)
    path = folder / "robot.xacro"
    try:
        text, _ = parsed(path.read_bytes(), path)
        parsed(resolved(text, path, shown=path, given=Given(), files=Folders(path, {})).encode(), path)
    except UsageError as error:
        if not str(error).isprintable():
            raise ValueError(f"not one line: {error}") from error
        return re.sub(r"'[^']*'|\d+|/\S*", "_", str(error))[:60]
    return "expanded"


def main() -> int:
    """Try inputs; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--inputs", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    ends: Counter[str] = Counter()
    longest = 0.0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name).resolve()
        for number in range(options.inputs):
            files = files_of(random.Random(f"{options.seed}/{number}"))
            start = time.process_time()
            try:
                ends[outcome(folder, files)] += 1
                longest = max(longest, time.process_time() - start)
                if longest > LIMIT:
                    raise TimeoutError(f"it took {longest:.1f} s")
            except Exception:
                place = Path("out/fuzz") / f"xacro-{options.seed}-{number}"
                place.mkdir(parents=True, exist_ok=True)
                for each, data in files.items():
                    (place / each).write_bytes(data)
                print(f"input {number} of seed {options.seed} is in {place}")
                raise
    print(f"{options.inputs} inputs, at most {longest:.2f} s each; {ends['expanded']} expanded")
    for end, count in ends.most_common(25):
        print(f"{count:8d}  {end}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
