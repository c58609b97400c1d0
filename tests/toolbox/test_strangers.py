"""Scripts as strangers write them: functions of arms, films and pictures of their own, names of files."""

import io
import shutil

import numpy as np
import pytest
from PIL import Image
from scipy.io import loadmat
from scipy.spatial.transform import Rotation
from scipy.stats import multivariate_normal

import mjsim
from mjsim.toolbox import run_script

pytestmark = [
    pytest.mark.slow,
    pytest.mark.timeout(300),
    pytest.mark.skipif(shutil.which("octave-cli") is None, reason="no Octave here"),
]
ARMS = """
mdl_puma560
q = [0.3 -0.4 0.5 0.6 -0.7 0.8]; qd = [0.1 -0.2 0.3 0.2 -0.1 0.4]; h = 1e-5;
[tau, wrench] = p560.rne(q, qz, qz);
m = [p560.links.m]; com = zeros(3, 6);
for k = 1:6, T = p560.A(1:k, q); com(:, k) = T(1:3, :) * [p560.links(k).r(:); 1]; end
asada = maniplty(p560, q, 'asada'); moves = p560.maniplty(q, 'T');
M = inertia(p560, q); J = jacob0(p560, q); Jt = jacob0(p560, q, 'trans');
Jr = jacob0(p560, q, 'rpy'); Je = jacob0(p560, q, 'eul');
for k = 1:6
  e = h * ((1:6) == k); T1 = p560.fkine(q + e); T0 = p560.fkine(q - e);
  rates(:, k) = (tr2rpy(T1) - tr2rpy(T0))' / (2 * h); turns(:, k) = (tr2eul(T1) - tr2eul(T0))' / (2 * h);
end
a = jacob_dot(p560, q, qd); slope = (jacob0(p560, q + h * qd) - jacob0(p560, q - h * qd)) / (2 * h) * qd';
C = coriolis(p560, [q; qn], [qd; qd]); C1 = coriolis(p560, q, qd); free = itorque(p560, [q; qn], [qd; qd]);
[T, frames] = p560.fkine(q); A3 = p560.A(1:3, q); words = trchain(p560); both = (p560 * p560).n;
turn = Quaternion(rpy2tr(0.1, 0.2, 0.3)); rate = dot(turn, [0.2 -0.1 0.3]); rate = rate.double;
wrapped = wrapToPi([pi -pi 3*pi 4 -4]); around = wrapTo180([180 -180 540 190]); whole = wrapTo2Pi([0 2*pi -1]);
[n, edges] = histcounts([1 2 2 3 5 5 5], 4); density = mvnpdf([0.1 0.2; -1 0.3], [0.5 0], [2 0.3; 0.3 1]);
there = contains({'robot', 'arm'}, 'bot'); flat = se2(1, 2, pi / 6);
clear p560; save('-v7', 'out.mat');
"""
PICTURES = """
figure(1); v = VideoWriter('waves.avi'); v.FrameRate = 5; open(v);
for k = 1:4, plot(1:9, sin((1:9) + k)); axis([0 10 -1 1]); f = getframe(gcf); writeVideo(v, f); end
close(v);
mdl_twolink
for k = 1:3
  figure(2); twolink.plot([k / 3, 0.5]); [A, map] = rgb2ind(frame2im(getframe(2)), 256);
  if k == 1, imwrite(A, map, 'arm.gif', 'LoopCount', Inf); else, imwrite(A, map, 'arm.gif', 'WriteMode', 'append'); end
end
figure(3); plot([1 2], 'LineWidth', 3); lines_ = findobj(gcf, 'type', 'line'); set(lines_, 'Color', 'r');
print -r200 -dpng sharp.png
imwrite(uint8(magic(4)), 'plain.png'); again = imread('plain.png');
thick = get(findobj(gca, 'Type', 'line'), 'Color'); size_ = size(get(gca, 'ColorOrder'));
save('-v7', 'out.mat', 'again', 'size_');
"""


def ran(tmp_path, text: str, name: str = "script.m"):
    (tmp_path / name).write_text(text)
    done = run_script(tmp_path / name, tmp_path / "out")
    assert done.error is None
    return done, loadmat(tmp_path / "out.mat", squeeze_me=True)


def test_functions_of_arms_are_those_of_their_definitions(tmp_path):
    _, got = ran(tmp_path, ARMS)
    weight = 9.81 * got["m"]
    x, y, _ = got["com"]
    np.testing.assert_allclose(got["wrench"], [0, 0, weight.sum(), y @ weight, -x @ weight, 0], atol=1e-12)
    inverse = np.linalg.inv(got["J"])
    felt = np.linalg.eigvalsh(inverse.T @ got["M"] @ inverse)
    assert got["asada"] == pytest.approx(felt[0] / felt[-1], rel=1e-6)
    assert got["moves"] == pytest.approx(np.sqrt(np.linalg.det(got["J"][:3] @ got["J"][:3].T)), rel=1e-10)
    np.testing.assert_array_equal(got["Jt"], got["J"][:3])
    np.testing.assert_allclose(got["Jr"][3:], got["rates"], atol=1e-8)
    np.testing.assert_allclose(got["Je"][3:], got["turns"], atol=1e-8)
    np.testing.assert_allclose(got["a"], got["slope"], atol=1e-8)
    np.testing.assert_allclose(got["C"][:, :, 0], got["C1"], atol=1e-15)
    np.testing.assert_allclose(got["frames"][:, :, 2], got["A3"], atol=1e-15)
    np.testing.assert_allclose(got["frames"][:, :, 5], got["T"], atol=1e-15)
    assert got["words"].startswith("Rz(q1)Rx(90)Rz(q2)Tx(0.4318)Rz(q3)Tz(0.15005)")
    assert got["both"] == 12


def test_itorque_has_a_row_for_each_row(tmp_path):
    _, got = ran(tmp_path, ARMS)
    puma = mjsim.arm("puma560")
    q = np.array([[0.3, -0.4, 0.5, 0.6, -0.7, 0.8], [0, np.pi / 4, np.pi, 0, np.pi / 4, 0]])
    np.testing.assert_allclose(got["free"], (puma.inertia(q) @ got["qd"]), rtol=1e-9)


def test_small_functions_are_those_of_scipy_and_numpy(tmp_path):
    _, got = ran(tmp_path, ARMS)
    before, after = (
        Rotation.from_rotvec(np.array([0.2, -0.1, 0.3]) * k * 1e-6) * Rotation.from_euler("ZYX", [0.1, 0.2, 0.3])
        for k in (-1, 1)
    )
    w, xyz = got["rate"][0], got["rate"][1:]
    slope = (after.as_quat(canonical=True) - before.as_quat(canonical=True)) / 2e-6
    np.testing.assert_allclose([*xyz, w], slope, atol=1e-8)
    np.testing.assert_allclose(got["wrapped"], [np.pi, -np.pi, np.pi, 4 - 2 * np.pi, 2 * np.pi - 4], atol=1e-12)
    np.testing.assert_array_equal(got["around"], [180, -180, 180, -170])
    np.testing.assert_allclose(got["whole"], [0, 2 * np.pi, 2 * np.pi - 1])
    np.testing.assert_array_equal(got["n"], np.histogram([1, 2, 2, 3, 5, 5, 5], 4)[0])
    exact = multivariate_normal([0.5, 0], [[2, 0.3], [0.3, 1]]).pdf([[0.1, 0.2], [-1, 0.3]])
    np.testing.assert_allclose(got["density"], exact, rtol=1e-12)
    assert got["there"].tolist() == [1, 0]
    np.testing.assert_allclose(got["flat"], [[np.sqrt(0.75), -0.5, 1], [0.5, np.sqrt(0.75), 2], [0, 0, 1]], atol=1e-15)


def test_films_animated_pictures_and_resolutions_are_those_of_the_script(tmp_path):
    import av

    done, got = ran(tmp_path, PICTURES)
    assert done.notes == ()
    with av.open(str(tmp_path / "out" / "waves.mp4")) as film:
        frames = [frame.to_ndarray(format="rgb24") for frame in film.decode(video=0)]
    # Four frames at 5 in a second, in a film of 25.
    assert len(frames) == 20
    assert np.abs(frames[0].astype(float) - frames[19]).max() > 100
    arm = Image.open(io.BytesIO((tmp_path / "out" / "arm.gif").read_bytes()))
    assert arm.n_frames == 3
    with Image.open(tmp_path / "out" / "sharp.png") as sharp:
        assert sharp.size == (1400, 1040)
    np.testing.assert_array_equal(got["again"][0], [16, 2, 3, 13])
    assert got["size_"].tolist() == [7, 3]


SE3 = """
L(1) = Link([0 0 1 0]); L(2) = Link([0 0 0.5 0]); r = SerialLink(L);
T = SE3(0.4, 0.2, 0) * SE3.Rx(pi / 3) * SE3.rpy([0.1 0.2 0.3]); p = T.t; R = T.R; M = T.T; % T.t stays
name = 'SE3(1)'; back = T.inv() * T;
Q = jtraj([0 0], [1 0.5], 5); Tr = r.fkine(Q); Tk = Tr(3); last = Tr(end).t; way = zeros(5, 3);
for i = 1:5, way(i, :) = transl(Tr(i)); end
x = Tk(1, 4); s.t = 3; y = s.t;
clear r L; save('-v7', 'out.mat');
"""


def test_poses_of_the_later_toolbox_are_matrices(tmp_path):
    _, got = ran(tmp_path, SE3)
    turned = Rotation.from_euler("x", np.pi / 3) * Rotation.from_euler("ZYX", [0.3, 0.2, 0.1])
    np.testing.assert_allclose(got["p"], [0.4, 0.2, 0])
    np.testing.assert_allclose(got["back"], np.eye(4), atol=1e-12)
    angles = got["Q"]
    x = np.cos(angles[:, 0]) + 0.5 * np.cos(angles.sum(axis=1))
    np.testing.assert_allclose(got["way"][:, 0], x, atol=1e-12)
    assert (got["x"], got["last"][0], got["y"]) == (pytest.approx(x[2]), pytest.approx(x[4]), 3)
    assert got["name"] == "SE3(1)"
    np.testing.assert_allclose(got["R"], turned.as_matrix(), atol=1e-12)


def test_sliders_tell_what_of_the_arm_they_lack(tmp_path):
    text = "mdl_twolink\ntwolink.tool = transl(0.1, 0, 0); teach(twolink); x = 1; save('-v7', 'out.mat', 'x');\n"
    done, _ = ran(tmp_path, text)
    assert done.notes == ("the arm of the sliders has no tool: a table of joints has none",)
    assert {file.suffix for file in done.files} == {".png", ".pdf", ".yaml"}


def test_a_script_may_have_the_name_of_a_function_that_arms_have(tmp_path):
    text = "mdl_puma560\nT = p560.fkine(qz); U = fkine(p560, qz); clear p560; save('-v7', 'out.mat');\n"
    _, got = ran(tmp_path, text, "fkine.m")
    np.testing.assert_array_equal(got["T"], got["U"])


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("function y = turned(angle, axis)\n  y = angle * axis;\nend\n", "is a function of angle, axis; run a script"),
        ("T = p560.fkine(qz);\n", "puma560 or mdl_puma560 at the top makes p560"),
        ("pkg load nosuch\n", "package nosuch is not installed; install octave-nosuch (turned.m:1)"),
        ("plot(1:3)\nx = q + 1;\n", "turned.m: 'q' undefined (turned.m:2)"),
        ("y = qz(1);\n", "puma560 or mdl_puma560 at the top"),
    ],
)  # fmt: skip
def test_a_mistake_is_told_with_what_to_do(tmp_path, text, told):
    (tmp_path / "turned.m").write_text(text)
    assert told in run_script(tmp_path / "turned.m", tmp_path / "out").error
