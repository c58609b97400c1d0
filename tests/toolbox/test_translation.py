"""Scripts of any encoding, with functions in files beside them, run as they are, and errors name the user's files."""

import math
import shutil
import sys

import numpy as np
import pytest
from scipy.io import loadmat
from scipy.spatial.transform import Rotation, Slerp

from mjsim.mechanics import Arm
from mjsim.modules import TOOLBOX
from mjsim.toolbox import run_script
from mjsim.toolbox.script_arms import start_of
from mjsim.toolbox.translation import decoded, renamed, translate
from tests.children import completed

needs_octave = pytest.mark.skipif(shutil.which("octave-cli") is None, reason="no Octave here")


@pytest.mark.parametrize(
    ("data", "text"),
    [
        ("Gelenkverl\xe4ufe in \xb0, gr\xf6\xdfer".encode("cp1252"), "Gelenkverl\xe4ufe in \xb0, gr\xf6\xdfer"),
        ("title('\u5de5\u4f5c\u7a7a\u95f4')".encode("gb18030"), "title('\u5de5\u4f5c\u7a7a\u95f4')"),
        ("\ufeff% \xe9".encode(), "% \xe9"),
    ],
)
def test_text_of_windows_is_read_as_it_was_written(data, text):
    assert decoded(data) == text


def test_functions_get_other_names_where_they_are_called_but_not_variables_and_sentences():
    assert renamed("y = f(2); x.f = 1; disp('f is'); feval('f', @f)", ["f"]) == (
        "y = mjsim_own_f(2); x.f = 1; disp('f is'); feval('mjsim_own_f', @mjsim_own_f)"
    )
    assert renamed("s = struct('f', 2);", ["f"]) == "s = struct('f', 2);"
    assert renamed("for f = 1:3, disp(f), end", ["f"]) == "for f = 1:3, disp(f), end"
    assert renamed("[a, f] = size(x); f + 1", ["f"]) == "[a, f] = size(x); f + 1"


LECTURE = """% Vorlesung: R\xfcckw\xe4rtsrechnung\r
clear all; close all; clc;\r
L{1} = link([pi/2 0.26 0 0.675 0]); L{2} = link([0 0.68 0 0 0]); L{3} = link([pi/2 -0.035 0 0 0]);\r
L{4} = link([-pi/2 0 0 0.67 0]); L{5} = link([pi/2 0 0 0 0]); L{6} = link([0 0 0 0.158 0]);\r
kr16 = robot(L, 'KR16', 'KUKA');\r
T1 = transl(1.2, 0.3, 0.9) * rotz(pi/4) * roty(pi/2 + 0.3);\r
q1 = ikine(kr16, T1, [0 pi/2 0 0 pi/6 0], 'tol', 1e-9, 'ilimit', 500);\r
reached = fkine(kr16, q1);\r
kinds = [kr16.links.alpha]; parts = [kr16.links(2:3).A];\r
chain = product(kr16, q1);\r
figure; plot(1:2); title('Gelenkverl\xe4ufe'); legend('q', 4)\r
save('-v7', 'lecture.mat', 'T1', 'reached', 'kinds', 'parts', 'chain');\r
x = ikine(kr16, transl(9, 9, 9), zeros(1, 6));\r
broken(1);\r
"""
PRODUCT = """function T = product(r, q)
  T = eye(4);
  n = numel(r.links.alpha);
  L = SerialLinks(r);
  for k = 1:6, T = T * L(k).A(q(k)); end
end
function L = SerialLinks(r)
  for k = 1:6
    o = r.link{k};
    L(k) = Link([0 o.D o.A o.alpha]);
  end
end
"""
BROKEN = """function broken(x)
  G = [x.links.G];
end
"""


@needs_octave
def test_copies_are_made_of_what_octave_cannot_run_and_of_methods_that_scripts_hide(tmp_path):
    for name, text in {
        "plain.m": "x = 1;\n",
        "fkine.m": "T = 1;\n",  # a script with the name of a method hides it
        "inertia.m": "function y = inertia(x)\ny = x;\n",  # a function takes its place
        "run_it.m": "function run_it(a, b)\ndisp(a + b)\n",
    }.items():
        (tmp_path / name).write_text(text)
    found = translate(tmp_path / "plain.m", tmp_path / "one")
    assert (found.run, found.is_function, found.parameters) == (tmp_path / "plain.m", False, ())
    written = {path.relative_to(tmp_path / "one").as_posix() for path in (tmp_path / "one").rglob("*.m")}
    assert written == {"@robot/fkine.m"}
    assert (tmp_path / "one" / "@robot" / "fkine.m").read_bytes() == (TOOLBOX / "fkine.m").read_bytes()
    found = translate(tmp_path / "run_it.m", tmp_path / "two")
    assert (found.run, found.is_function, found.parameters) == (tmp_path / "run_it.m", True, ("a", "b"))


@pytest.mark.slow
def test_a_lecture_with_files_beside_it_runs_to_its_mistake(tmp_path):
    (tmp_path / "lecture.m").write_bytes(LECTURE.encode("cp1252"))
    (tmp_path / "product.m").write_text(PRODUCT)
    (tmp_path / "broken.m").write_text(BROKEN)
    made = run_script(tmp_path / "lecture.m", tmp_path / "out")
    got = loadmat(tmp_path / "lecture.mat")
    np.testing.assert_allclose(got["reached"], got["T1"], atol=1e-9)
    np.testing.assert_allclose(got["chain"], got["reached"], atol=1e-12)
    np.testing.assert_allclose(got["kinds"].ravel(), np.array([1, 0, 1, -1, 1, 0]) * np.pi / 2)
    np.testing.assert_allclose(got["parts"].ravel(), [0.68, -0.035])
    cosine, sine = np.cos(np.pi / 4), np.sin(np.pi / 4)
    # Rz(45 deg) Ry(90 deg + 0.3), by hand.
    np.testing.assert_allclose(got["T1"][:3, 2], [cosine * np.cos(0.3), sine * np.cos(0.3), -np.sin(0.3)], atol=1e-12)
    assert any("does not reach 1 of 1 poses" in note for note in made.notes)
    assert made.error is not None
    assert made.error.endswith("(broken.m:2)")
    assert "mjsim_own" not in made.error


MODIFIED = """function modified
% Craig's table by links, and by the arm
  for k = 1:3, L(k) = Link([0 0.1 * k 0.2 (k - 1) * pi / 2], 'modified'); end
  r = SerialLink(L, 'name', 'three');
  q = [0.3 -0.5 0.7];
  A = L(1).A(q(1)) * L(2).A(q(2)) * L(3).A(q(3));
  T = r.fkine(q);
  [p, pd] = r.jtraj(r.fkine(q), r.fkine(q + 0.2), 5);
  kind = L(2).RP;
  save('-v7', 'modified.mat', 'A', 'T', 'q', 'p', 'kind');
end
"""


QUATERNIONS = """
v = [0.3 -0.5 0.7]; R = angvec2r(2.1, [1 2 -1]); p = [1 2 3; -4 0.5 2];
a = quaternion(R); b = UnitQuaternion.rpy(v); c = Quaternion(1.3, [0 0.6 0.8]); w = quaternion(1, 2, -3, 4);
product = double(a * b / c); whole = [double(w * a * 2); double(inv(w)); w.conj.double; double(w + a - b)];
lengths = [norm(w), w.unit.norm]; [w1, x1, y1, z1] = parts(w); first = [w1 x1 y1 z1; w.s w.v];
Ra = a.R; Ta = b.T; frame = rotmat(a, 'frame'); turned = [rotatepoint(a, p); rotateframe(a, p); (a * p')'];
path = double(a.interp(b, [0 0.25 1])); far = double(slerp(a, quaternion(-compact(a * UnitQuaternion.Rx(0.4))), 0.5));
power = double(a ^ 2.5); vectors = double(quaternion([v; 0 0 0], 'rotvec'));
euler = double(quaternion([v; -v], 'euler', 'ZYX', 'frame')); old = double(quaternion([0 0.6 0.8], 1.3));
halves = double(quaternion(cat(3, rotx(pi), roty(pi), rotz(pi), rotz(3.1), eye(3))));
some = a.interp(b, [0 1]); last = some(end).R;
pair = [a; b]; pair(3) = a; counts = [numel(pair), length(pair), numel(a)]; put = double(pair(end)) - double(a);
orders = cat(3, rpy2r(v, 'yxz'), rpy2r(v, 'xyz'), rpy2r(v, 'vehicle'), rpy2r(v * 50, 'deg', 'camera'));
back = [tr2rpy(orders(:, :, 1), 'yxz'); tr2rpy(orders(:, :, 2), 'arm'); tr2rpy(orders(:, :, 3), 'vehicle')];
L{1} = link([0.4 0.2 0 0.3 0]); L{2} = link([-0.2 0.1 0.5 0 1]); T = L{1}(0.7) * L{2}(0.9);
degrees = b.torpy('deg'); minus = double(-w); a.disp(), a.plot('frame', 'A'); clear a b c w some pair L
save('-v7', 'quaternions.mat')
"""


def test_sliders_start_where_drivebot_was_called():
    rows = [{"range_deg": [-225.0, 45.0]}, {"slide": True, "range": [0.0, 0.5]}, {}]
    assert start_of(rows, np.array([np.pi, 0.2, -1.0])) == pytest.approx([-180.0, 0.2, np.degrees(-1.0)])
    assert start_of(rows, np.array([np.pi / 2, 0.2, 0.0])) is None


@needs_octave
@pytest.mark.slow
def test_links_have_their_methods_in_a_function_too(tmp_path):
    (tmp_path / "modified.m").write_text(MODIFIED)
    assert run_script(tmp_path / "modified.m", tmp_path / "out").error is None
    got = loadmat(tmp_path / "modified.mat")
    rows = [{"d": 0.1 * k, "a": 0.2, "alpha": (k - 1) * np.pi / 2} for k in (1, 2, 3)]
    arm = Arm.from_dh(rows, "modified")
    np.testing.assert_allclose(got["A"], arm.fkine(got["q"][0]), atol=1e-12)
    np.testing.assert_allclose(got["T"], got["A"], atol=1e-12)
    np.testing.assert_allclose(
        arm.fkine(got["p"][[0, -1]]), arm.fkine(np.vstack([got["q"], got["q"] + 0.2])), atol=1e-9
    )
    assert got["kind"][0] == "R"


WORLD = """mjsim: 1
robots: [{name: scout, preset: pioneer3dx, at: [0, 0]}]
run: {seconds: 1, drivers: {scout: {navigator: {use: turn.m}}}}
"""
TURN = """function [cmd, state] = turn(obs, est, robot, state)
cmd.forward = 0.1; cmd.turn = 0.2;
state(end + 1) = obs.time;
if obs.time > 0.45 && obs.time < 0.55, figure(3); plot(state, 2 * state); xlabel('time [s]'); end
end
"""


@needs_octave
@pytest.mark.slow
def test_figures_of_a_module_are_beside_the_recording(tmp_path):
    (tmp_path / "w.yaml").write_text(WORLD)
    (tmp_path / "turn.m").write_text(TURN)
    (tmp_path / "w-figures").mkdir()
    (tmp_path / "w-figures" / "turn-figure-3.png").write_bytes(b"mine")
    done = completed([sys.executable, "-m", "mjsim.cli", "run", "w.yaml", "-o", "w.mcap"], cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "ignoring" not in done.stderr
    names = ["turn-figure-3.pdf", "turn-figure-3.png"]
    assert sorted(file.name for file in (tmp_path / "w-figures-2").glob("turn*")) == names
    assert (tmp_path / "w-figures" / "turn-figure-3.png").read_bytes() == b"mine"
    # What was drawn before a fault is kept, too.
    (tmp_path / "turn.m").write_text(TURN.replace("end\nend", "end\nif obs.time > 0.75, error('too far'); end\nend"))
    done = completed([sys.executable, "-m", "mjsim.cli", "run", "w.yaml", "-o", "v.mcap"], cwd=tmp_path, check=False)
    assert "too far" in done.stderr
    assert sorted(file.name for file in (tmp_path / "v-figures").glob("turn*")) == names
    assert sorted(done.stdout.split()) == [f"v-figures/{name}" for name in names]
    # Where they cannot be written, the fault is told as well.
    (tmp_path / "u-figures").write_text("mine")
    command = [sys.executable, "-m", "mjsim.cli", "run", "w.yaml", "-o", "u.mcap", "--overwrite"]
    done = completed(command, cwd=tmp_path, check=False)
    assert done.stdout.startswith("the figures of its modules are not written: ")
    assert "too far" in done.stderr
    assert (tmp_path / "u-figures").read_text() == "mine"


@needs_octave
@pytest.mark.slow
def test_quaternions_and_orders_of_turns_are_those_of_scipy(tmp_path):
    (tmp_path / "quaternions.m").write_text(QUATERNIONS)
    assert run_script(tmp_path / "quaternions.m", tmp_path / "out").error is None
    got = loadmat(tmp_path / "quaternions.mat")
    v, p = np.array([0.3, -0.5, 0.7]), np.array([[1, 2, 3], [-4, 0.5, 2]])
    a = Rotation.from_rotvec(2.1 * np.array([1, 2, -1]) / math.sqrt(6.0))
    b, c = Rotation.from_euler("ZYX", v[::-1]), Rotation.from_rotvec([0, 1.3 * 0.6, 1.3 * 0.8])
    w, unit = (
        np.array([1.0, 2.0, -3.0, 4.0]),
        [2 / math.sqrt(30), -3 / math.sqrt(30), 4 / math.sqrt(30), 1 / math.sqrt(30)],
    )

    def row(rotation):
        return rotation.as_quat(scalar_first=True)

    def same(name, expected):
        np.testing.assert_allclose(got[name], expected, rtol=0.0, atol=1e-12, err_msg=name)

    def same_turns(name, rotations):
        # q and -q are the same rotation.
        rows, expected = np.atleast_2d(got[name]), np.atleast_2d([row(each) for each in rotations])
        np.testing.assert_allclose(np.abs((rows * expected).sum(axis=1)), 1.0, rtol=0.0, atol=1e-12, err_msg=name)
        np.testing.assert_allclose(np.linalg.norm(rows, axis=1), 1.0, rtol=0.0, atol=1e-12, err_msg=name)

    scaled = math.sqrt(30.0) * 2.0 * row(Rotation.from_quat(unit) * a)
    whole = got["whole"]
    assert min(np.abs(whole[0] - scaled).max(), np.abs(whole[0] + scaled).max()) < 1e-12
    np.testing.assert_allclose(whole[1:3], [w * [1, -1, -1, -1] / 30.0, w * [1, -1, -1, -1]], atol=1e-12)
    np.testing.assert_allclose(whole[3], w + row(a) - row(b), atol=1e-12)
    same("lengths", [[math.sqrt(30.0), 1.0]])
    same("first", [w, w])
    same("Ra", a.as_matrix())
    same("Ta", np.block([[b.as_matrix(), np.zeros((3, 1))], [np.zeros((1, 3)), 1.0]]))
    same("frame", a.as_matrix().T)
    same("turned", np.vstack([a.apply(p), a.inv().apply(p), a.apply(p)]))
    same("degrees", [np.degrees(v)])
    same("minus", [-w])
    same("counts", [[3, 3, 1]])
    same("put", [[0, 0, 0, 0]])
    same("last", b.as_matrix())
    same("T", link_pose(0.4, 0.2, 0.7, 0.3) @ link_pose(-0.2, 0.1, 0.5, 0.9))
    same_turns("product", [a * b * c.inv()])
    same_turns("path", Slerp([0, 1], Rotation.concatenate([a, b]))([0, 0.25, 1]))
    same_turns("far", [a * Rotation.from_rotvec([0.2, 0, 0])])
    same_turns("power", [a**2.5])
    same_turns("vectors", [Rotation.from_rotvec(v), Rotation.identity()])
    same_turns("euler", [Rotation.from_euler("ZYX", v), Rotation.from_euler("ZYX", -v)])
    same_turns("old", [c])
    same_turns(
        "halves", [Rotation.from_euler(*each) for each in zip("xyzzz", (np.pi, np.pi, np.pi, 3.1, 0.0), strict=True)]
    )
    turns = [("YXZ", v[::-1]), ("XYZ", v[::-1]), ("ZYX", v[::-1]), ("YXZ", np.radians(50 * v[::-1]))]
    same("orders", np.dstack([Rotation.from_euler(*each).as_matrix() for each in turns]))
    same("back", [v, v, v])


def link_pose(alpha, a, theta, d):
    """Return the matrix of a link in the standard convention, by four elementary ones."""
    turn, tilt = np.eye(4), np.eye(4)
    turn[:3, :3], turn[2, 3] = Rotation.from_euler("z", theta).as_matrix(), d
    tilt[:3, :3], tilt[0, 3] = Rotation.from_euler("x", alpha).as_matrix(), a
    return turn @ tilt
