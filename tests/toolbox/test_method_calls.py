"""Methods of arms and links are calls in a script; what looks alike stays; the manner of a script is known."""

import pytest

from mjsim.toolbox.method_calls import is_old, with_calls


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        (
            "[q, e] = r.ikine(T); [t, x] = r.nofriction().fdyn(1);",
            "[q, e] = ikine(r, T); [t, x] = fdyn(r.nofriction(), 1);",
        ),
        ("T = L(3).A(q(3)) * r.links(2).A(0.1);",
         "T = mjsim_member(L(3), 'A', q(3)) * mjsim_member(r.links(2), 'A', 0.1);"),
        ("if L{k}.RP == 'R', x = 1; end", "if mjsim_member(L{k}, 'RP') == 'R', x = 1; end"),
        ("G = [p560.links.G]; m = sum([a.links.m]);", "G = [mjsim_links(p560).G]; m = sum([mjsim_links(a).m]);"),
        ("m = [r.links(2:3).m];", "m = [mjsim_links(r)(2:3).m];"),
        ("disp('L.A(q)'), r.A(2, q), sys.A(end) % L.A(q)", "disp('L.A(q)'), r.A(2, q), sys.A(end) % L.A(q)"),
        ("L{1} = link(a); L{2} = link(b); T = L{1}(0.3) * L{2}(q(2));",
         "L{1} = link(a); L{2} = link(b); T = mjsim_member(L{1}, '()', 0.3) * mjsim_member(L{2}, '()', q(2));"),
        ("A = Link(a); B(2) = Link(b); T = A(x) * B(x); A(1) = B(1); f{1}(2); disp('A(1)') % A(x)",
         "A = Link(a); B(2) = Link(b); T = mjsim_member(A, '()', x) * B(x); A(1) = B(1); f{1}(2); disp('A(1)') % A(x)"),
        ("r.links(2).m = 3; s.A(2) = 1; L.RP = 'P';", "r.links(2).m = 3; s.A(2) = 1; L.RP = 'P';"),
    ],
)  # fmt: skip
def test_methods_are_calls_and_assignments_text_and_other_indices_stay(line, expected):
    assert with_calls(line) == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("L1 = link([0 1 0 0 0]); r = robot({L1});", True),
        ("puma560\nT = p560;", True),
        ("T = transl(1, 2, 3) * rotx(pi / 2)", True),
        ("T = rotz(0.1) * transl([1 2 3])", True),
        ("L(1) = Link([0 0 1 0]); r = SerialLink(L); R = rotx(1);", False),
        ("r = robot(L); T = trotx(1);", False),
        ("R = rotx(0.1) * roty(0.2); % puma560", False),
    ],
)
def test_scripts_of_the_old_toolbox_are_known(text, expected):
    assert is_old(text) is expected
