"""USD files hold the scene in metres, at its places."""

import re

import numpy as np
import pytest

from mjsim.errors import UsageError
from mjsim.world import parse_world

pytest.importorskip("pxr", reason="usd-core has wheels for x86-64 only")

ROOM = """
mjsim: 1
walls: [{points: [[0, 0], [6, 0], [6, 4], [0, 4]], closed: true, height: 2.2, thickness: 0.2}]
obstacles: [{name: chest, box: [0.8, 0.5, 0.4], at: [2, 3], heading_deg: 90}]
beacons: [{name: owl-1, image: posters/owl.jpg, at: [0.11, 2], width: 0.8, center: 1.0}]
robots: [{name: scout, at: [4, 2]}]
"""


def corners(path: str, part: str) -> np.ndarray:
    """Return the corners of the meshes whose names hold a word, world frame, shape (n, 3)."""
    from pxr import Usd, UsdGeom

    stage = Usd.Stage.Open(path)
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1.0
    assert UsdGeom.GetStageUpAxis(stage) == "Z"
    found = []
    for prim in stage.Traverse():
        if prim.IsA(UsdGeom.Mesh) and part in prim.GetName():
            world_from_mesh = np.array(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(0.0))
            points = np.array(UsdGeom.Mesh(prim).GetPointsAttr().Get(0.0))
            found.append((np.column_stack([points, np.ones(len(points))]) @ world_from_mesh)[:, :3])
    return np.concatenate(found)


@pytest.mark.slow
def test_walls_things_and_pictures_stand_where_the_world_has_them(tmp_path):
    from mjsim.compile import write_usd

    path = write_usd(parse_world(ROOM), tmp_path / "room.usda")
    for part, low, high in [
        ("wall_seen", [-0.1, -0.1, 0], [6.1, 4.1, 2.2]),
        ("obstacle_chest", [1.75, 2.6, 0], [2.25, 3.4, 0.4]),
    ]:
        points = corners(str(path), part)
        np.testing.assert_allclose([points.min(axis=0), points.max(axis=0)], [low, high], atol=2e-3)
    owl = corners(str(path), "beacon_owl_1")
    np.testing.assert_allclose(np.ptp(owl, axis=0)[1], 0.8, atol=2e-3)
    np.testing.assert_allclose(owl.mean(axis=0), [0.11, 2, 1.0], atol=2e-3)
    named = set(re.findall("@room_pictures/(.*?)@", path.read_text()))
    assert named
    assert named <= {file.name for file in (tmp_path / "room_pictures").iterdir()}


@pytest.mark.slow
def test_the_validators_of_usd_find_no_fault(tmp_path):
    from pxr import Usd, UsdValidation

    from mjsim.compile import write_usd

    stage = Usd.Stage.Open(str(write_usd(parse_world(ROOM), tmp_path / "room.usdc")))
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    assert len(validators) > 10
    faults = UsdValidation.ValidationContext(validators).Validate(stage)
    assert [fault.GetErrorAsString() for fault in faults] == []


def test_a_name_without_a_usd_suffix_is_refused(tmp_path):
    from mjsim.compile import write_usd

    with pytest.raises(UsageError, match=r"ends in '\.obj'; a USD file ends in \.usda, \.usdc, \.usd"):
        write_usd(parse_world(ROOM), tmp_path / "room.obj")
