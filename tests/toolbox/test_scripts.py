"""Scripts in the manner of textbooks run in Octave: the numbers of `Arm` and of closed forms, and their figures."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid, solve_ivp
from scipy.io import loadmat
from scipy.spatial.transform import Rotation

import mjsim
from mjsim.mechanics import Arm, jtraj
from mjsim.toolbox import run_script
from mjsim.toolbox.handle_fields import without_fields
from mjsim.toolbox.local_functions import apart
from mjsim.toolbox.method_calls import with_calls

SCRIPTS = Path(__file__).parent / "scripts"
pytestmark = [
    pytest.mark.slow,
    pytest.mark.timeout(300),
    pytest.mark.skipif(shutil.which("octave-cli") is None, reason="no Octave here"),
]
UP6 = [(0, 0, 0.15, np.pi / 2), (0, 0, 0.57, 0), (0, 0, 0.13, np.pi / 2), (0, 0.64, 0, -np.pi / 2),
       (0, 0, 0, np.pi / 2), (0, 0.095, 0, 0)]  # fmt: skip
EXACT = {"rtol": 1e-12, "atol": 1e-12}


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """All scripts, one after the other in one Octave: the folder of their results, and what came of them."""
    folder = tmp_path_factory.mktemp("scripts")
    names = sorted(script.name for script in SCRIPTS.glob("*.m"))
    assert len(names) == 25
    for name in names:
        own, functions = apart(without_fields(with_calls((SCRIPTS / name).read_text())))
        for file, text in {Path(name).stem: own, **functions}.items():
            (folder / f"{file}.m").write_text(text)
    (folder / "all_of_them.m").write_text("".join(f"clear all; source('{name}');\n" for name in names))
    return folder, run_script(folder / "all_of_them.m", folder / "out")


def of(ran, name: str) -> dict[str, np.ndarray]:
    return loadmat(ran[0] / f"{name}.mat")


def test_every_script_runs_to_its_end(ran):
    assert ran[1].error is None
    assert not [note for note in ran[1].notes if "not drawn" in note]


def test_the_puma_of_the_scripts_is_that_of_mjsim(ran):
    # The preset's shoulder is above the floor, that of the old toolbox in the origin.
    puma, got = mjsim.arm("puma560"), of(ran, "s01")
    floor = np.eye(4)
    floor[2, 3] = -puma.links[0].dh[1]
    puma = puma.moved(floor)
    qn = [0, np.pi / 4, np.pi, 0, np.pi / 4, 0]
    for key, q in (("Tz", np.zeros(6)), ("Tr", [0, np.pi / 2, -np.pi / 2, 0, 0, 0]), ("Tn", qn)):
        np.testing.assert_allclose(got[key], puma.fkine(q), **EXACT)
    got = of(ran, "s04")
    np.testing.assert_allclose(got["tau"], puma.rne(got["q"], got["qd"], got["qdd"]), **EXACT)
    np.testing.assert_array_equal(got["tau"], got["same"])
    got = of(ran, "s05")
    q = np.zeros((*got["a"].shape, 6))
    q[..., 1], q[..., 2] = got["a"], got["b"]
    np.testing.assert_allclose(got["g"], puma.gravload(q)[..., 1], **EXACT)
    got = of(ran, "s06")
    np.testing.assert_allclose(got["Mn"], puma.inertia(qn), **EXACT)
    np.testing.assert_allclose(got["C"], puma.coriolis(qn, np.full(6, 0.3)), **EXACT)
    got = of(ran, "s07")
    np.testing.assert_allclose(got["J0"], puma.jacob0(qn), **EXACT)
    np.testing.assert_allclose(got["Jn"], puma.jacobe(qn), **EXACT)


def test_paths_are_those_of_mjsim(ran):
    got = of(ran, "s02")
    expected = jtraj(np.zeros(6), [0, np.pi / 2, -np.pi / 2, 0, 0, 0], got["t"].ravel())
    for key, values in zip(("q", "qd", "qdd"), expected, strict=True):
        np.testing.assert_allclose(got[key], values, **EXACT)


def test_rotations_in_later_words_are_those_of_scipy(ran):
    got, turn = of(ran, "s21"), Rotation
    np.testing.assert_allclose(got["R"], turn.from_euler("ZYX", [0.3, -0.7, 1.9]).as_matrix(), **EXACT)
    np.testing.assert_allclose(got["E"], turn.from_euler("ZYZ", [0.3, -0.7, 1.9]).as_matrix(), **EXACT)
    np.testing.assert_allclose(got["T"][:3, :3], turn.from_rotvec([0.4, 0.8, -0.8]).as_matrix(), **EXACT)
    np.testing.assert_allclose(got["angle"] * got["axis"], [[0.4, 0.8, -0.8]], **EXACT)
    np.testing.assert_allclose(np.abs(got["half"] * got["about"]), [[0.0, 0.6 * np.pi, 0.8 * np.pi]], **EXACT)
    np.testing.assert_allclose(got["S"] @ [1.0, 2.0, 3.0], np.cross(got["w"].ravel(), [1.0, 2.0, 3.0]), **EXACT)
    np.testing.assert_allclose(got["v"].ravel(), got["w"].ravel(), **EXACT)
    np.testing.assert_allclose(got["d"].ravel(), [1e-3, 2e-3, -1e-3, 1e-4, -2e-4, 3e-4], **EXACT)
    np.testing.assert_allclose(got["P"][:2, :2], got["R2"], **EXACT)
    np.testing.assert_allclose(got["at"].ravel(), [1.0, 2.0], **EXACT)


def test_quintics_and_blended_lines_begin_and_end_as_they_should_and_are_the_integrals_of_their_rates(ran):
    got = of(ran, "s21")
    for value, rate, ends in (
        ("s", "sd", [1.0, 3.0, 0.5, -0.2]),
        ("sd", "sdd", [0.5, -0.2, 0.0, 0.0]),
        ("l", "ld", [1.0, -2.0, 0.0, 0.0]),
    ):
        values, rates = got[value].ravel(), got[rate].ravel()
        np.testing.assert_allclose([values[0], values[-1], rates[0], rates[-1]], ends, atol=1e-12)
        grown = cumulative_trapezoid(rates, dx=0.1, initial=0.0)
        np.testing.assert_allclose(values - values[0], grown, atol=0.02)
    assert np.abs(got["ld"]).max() == pytest.approx(1.5 * 3.0 / 4.0)
    np.testing.assert_allclose(got["m"][[0, -1]], [[0.0, 5.0], [2.0, -1.0]], **EXACT)
    np.testing.assert_allclose(got["m"][:, 1], 5.0 - 3.0 * got["m"][:, 0], **EXACT)


def test_inverse_kinematics_reaches_its_poses(ran):
    for name, wanted, reached in (("s03", "T", "reached"), ("s08", "T", "again")):
        got = of(ran, name)
        np.testing.assert_allclose(got[reached], got[wanted], atol=1e-9)


def test_both_orders_of_links_make_the_same_arm(ran):
    arm, q = Arm.from_dh(UP6), of(ran, "s08")["q"][0]
    for name in ("s08", "s09"):
        np.testing.assert_allclose(of(ran, name)["T"], arm.fkine(q), **EXACT)
    got = of(ran, "s09")
    np.testing.assert_allclose(got["Tt"][:3, 3], got["T"][:3, 3] + 0.1 * got["T"][:3, 2], **EXACT)


def test_a_planar_arm_moves_and_weighs_as_its_closed_form(ran):
    got, (a, b), (u, v), (x, y) = of(ran, "s10"), (0.3, 0.5), (0.2, -0.4), (1.0, 2.0)
    p = [np.cos(a) + 0.7 * np.cos(a + b), np.sin(a) + 0.7 * np.sin(a + b), 0.0]
    np.testing.assert_allclose(got["p"].ravel(), p, **EXACT)
    g2 = 9.81 * 0.35 * np.cos(a + b)
    g1 = 9.81 * (2 * 0.5 + 1) * np.cos(a) + g2
    np.testing.assert_allclose(got["g"].ravel(), [g1, g2], **EXACT)
    own, side, h = 0.35**2 + 0.1, 0.35 * np.cos(b), 0.35 * np.sin(b)
    tau = [
        (2 * 0.25 + 1 + own + 2 * side) * x + (own + side) * y - h * (2 * u * v + v * v) + g1,
        (own + side) * x + own * y + h * u * u + g2,
    ]
    np.testing.assert_allclose(got["tau"].ravel(), tau, **EXACT)


def test_slides_and_modified_tables_are_those_of_mjsim(ran):
    rows = [{"d": 0.4}, {"alpha": -np.pi / 2, "slide": True}, {"slide": True}]
    slider, got = Arm.from_dh(rows), of(ran, "s11")
    np.testing.assert_allclose(got["T"], slider.fkine([np.pi / 3, 0.2, 0.5]), **EXACT)
    np.testing.assert_allclose(got["J"], slider.jacob0([np.pi / 3, 0.2, 0.5]), **EXACT)
    table = [{"d": 0.3}, {"alpha": -np.pi / 2, "a": 0.1}, {"a": 0.5, "d": 0.1}]
    masses = [{"mass": k, "center": [0.1, 0.02 * k, 0.03], "inertia": [0.1, 0.2, 0.3, 0, 0, 0]} for k in (1, 2, 3)]
    arm, got = Arm.from_dh([a | b for a, b in zip(table, masses, strict=True)], "modified"), of(ran, "s12")
    q, qd, qdd = (got[key][0] for key in ("q", "qd", "qdd"))
    np.testing.assert_allclose(got["T"], arm.fkine(q), **EXACT)
    np.testing.assert_allclose(got["J"], arm.jacob0(q), **EXACT)
    np.testing.assert_allclose(got["tau"][0], arm.rne(q, qd, qdd), **EXACT)
    np.testing.assert_allclose(got["M"], arm.inertia(q), **EXACT)


def test_frames_controllers_and_energies_are_right(ran):
    got = of(ran, "s13")
    np.testing.assert_allclose(got["rpy"][0], [0.1, 0.2, 0.3], **EXACT)
    np.testing.assert_allclose(got["eul"][0], [0.1, 0.2, 0.3], **EXACT)
    np.testing.assert_allclose(got["half"][:2, :2], [[np.cos(0.5), -np.sin(0.5)], [np.sin(0.5), np.cos(0.5)]], **EXACT)
    # Euler's steps of 0.02 s leave 0.008.
    assert np.abs(of(ran, "s15")["last"]).max() < 0.02
    got = of(ran, "s20")
    # Two rods of 1 m along x of a vertical plane that they leave: z is up, so nothing pulls in it.
    np.testing.assert_allclose(got["k"], 0.0, atol=1e-9)
    got = of(ran, "s19")
    np.testing.assert_array_equal(got["T"], got["S"])


def test_figures_arms_and_films_are_files(ran):
    folder, made = ran
    names = {file.name for file in made.files}
    numbers = (20, 30, 40, 50, 80, 140, 150, 160, 170, 180, 190, 200)
    assert names >= {f"figure-{number}.{kind}" for number in numbers for kind in ("png", "pdf")}
    assert {"figure-140.mp4", "swing.png", "by_matrix.yaml"} <= names
    assert all((folder / "out" / name).stat().st_size > 1000 for name in names if not name.endswith("yaml"))
    assert made.driven is not None
    assert mjsim.arm(str(made.driven)).n == 2


def test_letters_that_no_font_has_are_told(ran):
    told = [note for note in ran[1].notes if note.startswith("figure 180: ")]
    assert told == ["figure 180: no installed font has 'ワークスペ'; install fonts-noto-cjk"] or not told


def test_closed_forms_of_the_puma_reach_the_pose_in_all_configurations(ran):
    got = of(ran, "s22")
    # Corke, Robotics, Vision and Control (2011), section 7.3.1, prints these; its second angle is -3.9270.
    np.testing.assert_allclose(got["left"].ravel(), [2.6486, 2.3562, 0.0940, 2.5326, 0.9743, 0.3734], atol=1e-4)
    np.testing.assert_allclose(np.cos(got["right"].ravel()), np.cos([0, np.pi / 4, np.pi, 0, np.pi / 4, 0]), atol=1e-12)
    np.testing.assert_allclose(got["reached"], np.repeat(got["Tk"][..., None], 8, axis=2), atol=1e-12)
    assert len(np.unique(np.round(got["all_"], 6), axis=0)) == 8
    assert got["q2"].shape[1] == 6


def test_lines_with_blends_pass_their_ends_and_keep_their_speed(ran):
    got = of(ran, "s22")
    p, t = got["p"], got["t"].ravel()
    np.testing.assert_allclose(p[[0, -1]], [[0, 0], [1, 1]], atol=1e-12)
    speed = np.diff(p, axis=0) / np.diff(t)[:, None]
    assert (np.abs(speed).max(axis=0) <= [1.0 + 1e-9, 2.0 + 1e-9]).all()
    # From rest to 1 in 0.2 s: 5.
    assert np.abs(np.diff(speed[:, 0]) / 0.05).max() == pytest.approx(5.0)


def test_exponents_norms_and_wrenches_are_those_of_numpy(ran):
    got = of(ran, "s22")
    T, R = got["Tk"], got["Tk"][:3, :3]
    np.testing.assert_allclose(got["R"], T, atol=1e-12)
    np.testing.assert_allclose(got["S"], T, atol=1e-12)
    turn = Rotation.from_matrix(R)
    np.testing.assert_allclose(np.radians(got["a"].ravel()), turn.as_euler("ZYX"), atol=1e-12)
    np.testing.assert_allclose(got["moved"], R @ [[1, 2], [3, 4], [5, 6]] + T[:3, 3:], atol=1e-12)
    force, moment = R.T @ [1, 2, 3], R.T @ (np.array([4, 5, 6]) + np.cross([1, 2, 3], T[:3, 3]))
    np.testing.assert_allclose(got["W"].ravel(), [*force, *moment], atol=1e-12)
    ahead, back = (Rotation.from_euler("ZYZ", [0.3, 0.5 + step, 0.7]).as_matrix() for step in (1e-6, -1e-6))
    spin = (ahead - back) / 2e-6 @ Rotation.from_euler("ZYZ", [0.3, 0.5, 0.7]).as_matrix().T
    np.testing.assert_allclose(got["J"][:, 1], [spin[2, 1], spin[0, 2], spin[1, 0]], atol=1e-8)


def test_counts_of_a_histogram_are_those_of_numpy(ran):
    got = of(ran, "s23")
    count, edges = np.histogram([1, 1, 2.5, 5], 4)
    np.testing.assert_array_equal(got["n"].ravel(), count)
    np.testing.assert_allclose(got["c"].ravel(), (edges[1:] + edges[:-1]) / 2)


def test_arms_move_under_torques_and_dry_friction_holds_them(ran):
    got = of(ran, "s25")
    # 0.5 N m brake 0.5 kg m^2 from 1 rad/s: 0.5 rad in 1 s, and no motion from then on.
    assert got["q1"][-1, 0] == pytest.approx(0.5, abs=1e-3)
    assert (got["qd1"][got["t1"] > 1.001] == 0.0).all()
    assert got["t1"][-1] == pytest.approx(1.4)
    np.testing.assert_allclose(got["q3"], got["q4"], **EXACT)
    puma, qr, qn = mjsim.arm("puma560"), np.array([0, np.pi / 2, -np.pi / 2, 0, 0, 0]), np.array([0, 1, 4, 0, 1, 0])
    gear, viscous, dry = np.abs(got["G"].ravel()), got["B"].ravel(), got["Tc"]

    def rate(_, x):
        # Dry friction as a steep slope through zero, which needs a stiff integrator.
        q, qd = x[:6], x[6:]
        torque = -20.0 * np.array([0, 1, 1, 0, 0, 0]) * (q - qn * np.pi / 4)
        friction = gear**2 * viscous * qd + gear * np.where(qd > 0, dry[0], -dry[1]) * np.tanh(qd / 1e-4)
        rest = torque - puma.coriolis(q, qd) @ qd - puma.gravload(q) - friction
        return np.concatenate([qd, np.linalg.solve(puma.inertia(q), rest)])

    exact = solve_ivp(rate, (0.0, 0.3), [*qr, *np.zeros(6)], method="LSODA", rtol=1e-6, atol=1e-7)
    np.testing.assert_allclose(got["q2"][-1], exact.y[:6, -1], atol=3e-3)
    np.testing.assert_array_equal(got["q2"][:, [0, 3, 5]], 0.0)
    np.testing.assert_array_equal(got["rows"][1], got["single"].ravel())
    np.testing.assert_array_equal(got["rows"][0], got["stacked"].ravel())
    expected = np.linalg.solve(puma.inertia(qr), -puma.rne(qr, np.ones(6), np.zeros(6)))
    np.testing.assert_allclose(got["single"].ravel(), expected, rtol=1e-9)


def test_figures_tell_their_limits_and_data_and_arms_carry_what_they_are_given(ran):
    got = of(ran, "s24")
    np.testing.assert_allclose(got["v"], [[0, 1.5, -1, 1]])
    np.testing.assert_allclose(got["w"], [[0, 3, -1, 1]])
    np.testing.assert_allclose([got["x"][0], got["y"][0]], [[0, 1.5], [1, 2]])
    assert got["f"] == 242
    assert (ran[0] / "out" / "told.eps").read_bytes().startswith(b"%!PS")
    # 1 kg in the middle of the first rod of 1 m, and 2 kg at 2 m.
    np.testing.assert_allclose(got["g"], [[9.81 * (0.5 + 2 * 2), 9.81 * 2]], **EXACT)
    np.testing.assert_allclose(got["b"], [[0.0, 4 * 0.5 * 2 + 2 * 0.3]], **EXACT)
    np.testing.assert_allclose(got["T"], 0.0, atol=1e-12)
    np.testing.assert_allclose(got["miss"], 0.0, atol=1e-9)
    assert (np.abs(got["q"]) <= 3.0).all()
    assert got["t"][-1] == pytest.approx(0.01)
