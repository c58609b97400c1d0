"""Read broken models by the thousand: each must stand in a scene, or be refused in one line.

python scripts/fuzz/models.py [--inputs 100000] [--seed 1]

Takes the shipped furniture and a few files with a bit of everything, and changes values, names, bytes and pieces. The
first input that ends otherwise, or takes longer than a limit, is written to out/fuzz and ends the script with exit
code 1; one that brings the process down is left in out/fuzz too.
"""

import argparse
import random
import re
import sys
import time
from collections import Counter
from pathlib import Path

from mjsim.compile import check_models, compile_world
from mjsim.errors import WorldError
from mjsim.guarded import one_reader
from mjsim.world import Source, parse_world

LIMIT = 5.0
"""No input may take longer, on a busy machine [s]."""
ROOT = Path(__file__).resolve().parents[2]
WEDGE = (
    b"v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3\nvt 0 0\nvt 1 1\nf 1/1 3/2 2/1\nf 1/1 2/2 4/1\nf 2/1 3/2 4/1\nf 3/1 1/2 4/1\n"
)
MJCF = b"""<mujoco><compiler angle="radian" eulerseq="zYx" meshdir="meshes"/>
<default><geom type="box" size="0.1 0.2 0.3"/><default class="round"><geom type="cylinder" euler="0.3 0 0"/></default>
</default><asset><mesh name="wedge" file="wedge.obj" scale="0.5 1 -1" refpos="0.2 0.1 0" refquat="0.8 0 0.6 0"/>
<mesh name="inline" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/><material name="m" rgba="1 0 0 1" texture="t"/>
<texture name="t" type="2d" builtin="checker" width="8" height="8" rgb1="1 1 1"/></asset>
<worldbody><geom pos="3 0 0" euler="0.1 0.2 0.3" material="m"/><include file="part.xml"/>
<body name="b" pos="0 1 0" axisangle="1 2 0 0.7" childclass="round"><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
<geom/><geom size="0.2" zaxis="1 1 0"/><frame pos="0 0 2" quat="0.6 0.8 0 0"><body pos="1 0 0">
<joint type="slide" axis="0 1 0" ref="0.2" range="-1 1" stiffness="3" damping="1"/>
<geom type="capsule" fromto="0 0 0 1 2 3" size="0.1"/><geom type="mesh" mesh="wedge" xyaxes="0 1 0 -1 0 1"/>
<geom type="mesh" mesh="inline" group="3"/></body></frame></body>
<replicate count="3" offset="1 0 0.1" euler="0 0 0.4"><body><joint type="ball"/><geom size="0.05"/></body></replicate>
</worldbody><contact><exclude body1="b" body2="b"/></contact></mujoco>"""
URDF = b"""<robot name="cupboard"><link name="case"><visual><geometry><sphere radius="2"/></geometry></visual>
<collision><origin xyz="0 0 0.5" rpy="0 0 0.4"/><geometry><box size="0.4 0.8 1"/></geometry></collision></link>
<link name="door"><inertial><mass value="3"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><geometry><mesh filename="meshes/wedge.obj" scale="0.1 0.2 0.3"/></geometry></collision>
<collision><geometry><cylinder radius="0.05" length="0.9"/></geometry></collision></link>
<joint name="hinge" type="revolute"><parent link="case"/><child link="door"/><origin xyz="0.2 -0.4 0.5"/>
<axis xyz="0 0 1"/><limit lower="0" upper="1.5" effort="9" velocity="9"/></joint></robot>"""
PART = b'<mujocoinclude><geom pos="0 0 -1" quat="1 1 0 0"/></mujocoinclude>'
WILD = (
    *(b"", b"0", b"-1", b"nan", b"inf", b"1e9", b"1e-300", b"1e400", b"9" * 30, b"a", b"\xff", b"1 2 3", b"0 0 0"),
    *(b"..", b"/etc/passwd", b"../up.obj", b"part.xml", b"mesh", b"sphere", b"capsule", b"plane", b"hfield", b"free"),
    *(b"true", b"<geom/>", b"<body>", b"</body>", b'<joint type="free"/>', b"<frame>", b"&amp;", b"&x;"),
)
"""What stands where a value should."""


def seeds() -> list[tuple[str, bytes]]:
    """Return names and contents of the files that are changed."""
    furniture = sorted((ROOT / "assets" / "furniture").iterdir())
    return [*((path.name, path.read_bytes()) for path in furniture), ("all.xml", MJCF), ("all.urdf", URDF)]


def changed(data: bytes, rng: random.Random) -> bytes:
    """Return a file with a few changes."""
    for _ in range(rng.choice((1, 1, 1, 2, 3, 6))):
        pattern = rng.choice((rb'"([^"]*)"', rb'"([^"]*)"', rb'"([^"]*)"', rb"[ <](\w+)[= />]"))
        places = [match.span(1) for match in re.finditer(pattern, data)] or [(0, 0)]
        start, end = rng.choice(places)
        other, last = rng.choice(places)
        at = rng.randrange(len(data) + 1)
        data = rng.choice(
            (
                data[:start] + rng.choice(WILD) + data[end:],
                data[:start] + data[other:last] + data[end:],
                data[:at] + bytes([rng.randrange(256)]) + data[at + 1 :],
                data[:at] + data[start : start + rng.randrange(80)] + data[at:],
                data[:at] + data[at + rng.randrange(40) :],
            )
        )
    return data


def trial(name: str, data: bytes, mesh: bytes, *, movable: bool) -> str:
    """Read a model as `mjsim check` and `mjsim run` do, and return what became of it.

    Raises:
        TimeoutError: It took too long.
    """
    attached = {name: data, "part.xml": PART, "meshes/wedge.obj": mesh}
    text = f"mjsim: 1\nobstacles: [{{name: thing, model: {name}, at: [1, 2], movable: {str(movable).lower()}}}]\n"
    start = time.perf_counter()
    try:
        world = parse_world(text, source=Source(attached=attached))
        check_models(world)
        compile_world(world).compile()
        end = "a thing"
    except WorldError as error:
        (line,) = str(error).splitlines()
        assert line.isprintable()
        end = "refused"
    if (taken := time.perf_counter() - start) > LIMIT:
        raise TimeoutError(f"reading took {taken:.1f} s")
    return end


def run(count: int, *, seed: int, folder: Path) -> Counter[str]:
    """Try so many inputs, each of which lies in a folder while it is tried; return what became of them."""
    rng, files, ends = random.Random(seed), seeds(), Counter[str]()
    folder.mkdir(parents=True, exist_ok=True)
    for _ in range(count):
        name, data = rng.choice(files)
        data, mesh = changed(data, rng), changed(WEDGE, rng) if rng.random() < 0.2 else WEDGE
        last, last_mesh = folder / f"last-{name}", folder / "last-wedge.obj"
        last.write_bytes(data)
        last_mesh.write_bytes(mesh)
        ends[trial(name, data, mesh, movable=rng.random() < 0.5)] += 1
        last.unlink()
        last_mesh.unlink()
    return ends


def main() -> None:
    """Try as many inputs as the arguments say."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--inputs", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    folder, done, start = ROOT / "out" / "fuzz", Counter[str](), time.process_time()
    while (left := arguments.inputs - done.total()) > 0:
        with one_reader("mjsim.models.trials:model"):
            done += run(min(left, 1000), seed=arguments.seed + done.total(), folder=folder)
        print(f"{done.total()} inputs: {dict(done)}, {time.process_time() - start:.0f} s of CPU", file=sys.stderr)


if __name__ == "__main__":
    main()
