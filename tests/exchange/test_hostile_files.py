"""Files that crash, stop or bloat the libraries that read them become one line and exit code 2."""

import os
import struct
import zlib

import ezdxf
import numpy as np
import pytest
from scipy.io import savemat

from mjsim.cli import main
from mjsim.errors import UsageError
from mjsim.exchange import bring_file
from mjsim.exchange.drawings.drawing import Drawing, Line
from mjsim.exchange.drawings.plan_in import read_plan

SVG = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 1300 1000">{}</svg>'


def element(kind: int, data: bytes) -> bytes:
    """Return a data element of a MAT-file of version 5."""
    return struct.pack("<II", kind, len(data)) + data.ljust(-(-len(data) // 8) * 8, b"\0")


def matrix(count: int, data: bytes, *, flags: int = 6, kind: int = 9) -> bytes:
    """Return a MAT-file with one matrix `lm` of 2 x `count` doubles, from the elements after its name."""
    head = b"MATLAB 5.0 MAT-file".ljust(124) + struct.pack("<HH", 0x0100, 0x4D49)
    begin = element(6, struct.pack("<II", flags, 0)) + element(5, struct.pack("<ii", 2, count))
    return head + element(14, begin + struct.pack("<HH", 1, 2) + b"lm\0\0" + data)


def bomb() -> bytes:
    """Return a MAT-file of megabytes that unpacks to a gigabyte of zeros, and twice as much while it is read."""
    count = 60_000_000
    packer = zlib.compressobj(1)
    whole = matrix(count, b"")[128:][8:]
    head = struct.pack("<II", 14, len(whole) + 8 + 16 * count) + whole + struct.pack("<II", 9, 16 * count)
    packed = packer.compress(head) + packer.flush(zlib.Z_FULL_FLUSH)
    zeros = packer.compress(bytes(16 * 10**6)) + packer.flush(zlib.Z_FULL_FLUSH)  # stands by itself
    packed += zeros * (count // 10**6)
    return matrix(1, b"")[:128] + struct.pack("<II", 15, len(packed)) + packed


def refused(path, capfd, *options):
    """Return the only line that the command says about a file."""
    with pytest.raises(SystemExit) as left:
        main(["new", "--from", str(path), "-o", str(path.parent / "w.yaml"), *options])
    assert left.value.code == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert path.name in err
    assert not (path.parent / "w.yaml").exists()
    return err


def test_a_matrix_of_a_sparse_kind_without_its_indices_is_one_line(tmp_path, capfd):
    # The reader of sparse matrices believes their indices.
    indices = element(5, struct.pack("<i", 2**30)) + element(5, struct.pack("<ii", -(2**30), 2**30))
    (tmp_path / "a.mat").write_bytes(matrix(1, indices + element(9, struct.pack("<d", 1.0)), flags=5))
    refused(tmp_path / "a.mat", capfd)


@pytest.mark.slow
def test_a_matrix_that_unpacks_to_gigabytes_is_one_line(tmp_path, capfd):
    (tmp_path / "a.mat").write_bytes(bomb())
    assert "it needs more than" in refused(tmp_path / "a.mat", capfd)


@pytest.mark.parametrize(
    "shape",
    [
        '<path d="M325,462v90c49.7,0,90-40.3,1e308-90" stroke="black"/>',
        '<path d="M0 0 L 1e308 1e308 L -1e308 4" stroke="black"/>',
        '<rect x="-1e300" y="0" width="1e308" height="4" stroke="black"/>',
        '<circle cx="0" cy="0" r="1e200" stroke="black"/>',
        '<g transform="scale(1e200)"><rect x="1" y="1" width="9" height="9" stroke="black"/></g>',
    ],
)
def test_coordinates_beyond_all_buildings_are_one_line(tmp_path, capfd, shape):
    (tmp_path / "a.svg").write_text(
        SVG.format(f'<rect x="100" y="100" width="1000" height="700" stroke="black"/>{shape}')
    )
    refused(tmp_path / "a.svg", capfd, "--scale", "0.01")


def test_lines_that_all_cross_each_other_are_one_line():
    ends = np.random.default_rng(1).uniform(0.0, 10.0, (6000, 2, 2))
    with pytest.raises(UsageError, match=r"'a\.svg' has 1\d million pairs of lines that may cross; name the --layer"):
        read_plan(Drawing("a.svg", [Line(each) for each in ends]), scale=1.0)


@pytest.mark.parametrize("far", [1e13, 1e308, float("inf"), float("nan")])
@pytest.mark.parametrize("kind", ["line", "face", "arc"])
def test_coordinates_of_dxf_are_bounded_too(tmp_path, kind, far):
    document = ezdxf.new(units=6)
    space = document.modelspace()
    space.add_lwpolyline([(0, 0), (6, 0), (6, 4), (0, 4)], close=True)
    if kind == "line":
        space.add_line((0, 0), (far, 1))
    elif kind == "face":
        space.add_3dface([(0, 0), (far, 0), (0, 3)])
    else:
        space.add_arc((0, far), 2, 0, 90)
    document.saveas(tmp_path / "a.dxf")
    with pytest.raises(UsageError, match=r"a\.dxf"):
        bring_file(tmp_path / "a.dxf", robot=None)


@pytest.mark.parametrize("name", ["map.yaml", "map.png", "plan.svg", "plan.dxf", "map.mat"])
def test_a_pipe_a_device_and_a_link_in_a_circle_are_no_files(tmp_path, capfd, name):
    os.mkfifo(tmp_path / name)
    refused(tmp_path / name, capfd, *(["--scale", "1"] if name.endswith("png") else []))
    (tmp_path / name).unlink()
    (tmp_path / name).symlink_to("/dev/zero")
    refused(tmp_path / name, capfd, *(["--scale", "1"] if name.endswith("png") else []))
    (tmp_path / name).unlink()
    (tmp_path / name).symlink_to(name)
    refused(tmp_path / name, capfd, *(["--scale", "1"] if name.endswith("png") else []))


def test_a_map_whose_picture_is_a_pipe_is_one_line(tmp_path):
    (tmp_path / "map.yaml").write_text("image: map.pgm\nresolution: 0.05\n")
    os.mkfifo(tmp_path / "map.pgm")
    with pytest.raises(
        UsageError, match=r"map\.pgm. cannot be read: it is a pipe or a device, not a file; name the picture of a map"
    ):
        bring_file(tmp_path / "map.yaml", robot=None)


def test_links_to_a_map_elsewhere_are_followed(tmp_path):
    # A ROS workspace that is built with links has such maps.
    (tmp_path / "src").mkdir()
    (tmp_path / "install").mkdir()
    (tmp_path / "src/map.yaml").write_text("image: map.pgm\nresolution: 0.5\n")
    cells = np.full((20, 20), 254, np.uint8)
    cells[0] = cells[-1] = cells[:, 0] = cells[:, -1] = 0
    (tmp_path / "src/map.pgm").write_bytes(b"P5\n20 20\n255\n" + cells.tobytes())
    for name in ("map.yaml", "map.pgm"):
        (tmp_path / "install" / name).symlink_to(tmp_path / "src" / name)
    assert "walls:" in bring_file(tmp_path / "install/map.yaml", robot=None).text


def test_a_landmark_map_still_comes_in(tmp_path):
    savemat(tmp_path / "a.mat", {"lm": np.eye(2), "wp": np.zeros((2, 2))})
    assert "lm2" in bring_file(tmp_path / "a.mat", robot=None).text
