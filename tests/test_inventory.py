"""The list at the end of an import: what became of each part of a file."""

from mjsim.inventory import Fate, FileItem, inventory


def test_what_was_left_out_is_listed_by_reason_after_what_was_kept():
    items = [
        FileItem(Fate.LEFT_OUT, "lidar", "near_0", "too many"),
        FileItem(Fate.KEPT, "lidar", "scan"),
        FileItem(Fate.LEFT_OUT, "mesh", "a.dae", "broken"),
        FileItem(Fate.LEFT_OUT, "lidar", "near_1", "too many"),
        FileItem(Fate.GUESSED, "speed", why="0.3 m/s"),
    ]
    assert inventory(items) == [
        "kept: lidar 'scan'",
        "guessed: speed: 0.3 m/s",
        "left out: 2 lidars 'near_0', 'near_1': too many",
        "left out: mesh 'a.dae': broken",
    ]


def test_many_of_one_kind_are_one_line_of_bounded_length():
    named = [FileItem(Fate.LEFT_OUT, "entity", f"e{n}", "3-D") for n in range(300)]
    (line,) = inventory([*named, *named])
    assert line.startswith("left out: 600 entities 'e0', 'e1'")
    assert line.endswith("'e7' and 292 more: 3-D")
    assert inventory([FileItem(Fate.LEFT_OUT, "box")] * 2) == ["left out: 2 boxes"]
    assert inventory([FileItem(Fate.LEFT_OUT, "look of meshes")] * 2) == ["left out: 2 looks of meshes"]
