"""Bags as they should not be: cut, in pieces, out of order, misnamed, unclear."""

import math
import re
from types import SimpleNamespace

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.writer import Writer

import mjsim
from mjsim.errors import UsageError
from mjsim.geometry import Pose, Pose3
from mjsim.logs import Wishes, listed
from mjsim.logs.bags.bag_file import Bag as RosBag
from mjsim.logs.bags.bag_frames import matrix_of
from tests.bags import START, new_bag, write_scans
from tests.real_logs import imported, run_command


def test_ranges_that_are_no_numbers_and_scans_from_left_to_right_are_told_as_ours(tmp_path):
    write_scans(tmp_path / "plain")
    write_scans(tmp_path / "reversed", first=0.3, step=-0.1)
    inf = math.inf
    for name, ranges in (("plain", [-inf, -inf, -inf, 1.0, 3.0, inf, inf]), ("reversed", None)):
        run = imported(tmp_path / name, wishes=Wishes(seconds=0.3))
        scan = next(seen.scans["scan"] for seen in run.observations("robot") if seen.scans)
        np.testing.assert_array_equal(scan.ranges, ranges or [inf, inf, 3.0, 1.0, -inf, -inf, -inf])
        assert scan.angle_increment > 0.0
        np.testing.assert_allclose(scan.angles(), np.linspace(-0.3, 0.3, 7), atol=1e-6)


def test_a_lidar_that_hangs_sees_its_left_on_the_robots_right(tmp_path):
    with new_bag(tmp_path / "run.bag", "bag") as bag:
        hung = np.diag([1.0, -1.0, -1.0, 1.0])
        fixed = bag.transform(bag.header(START, "/base_link"), "/laser", hung)
        bag.put("/tf", START, bag.make("tf2_msgs/TFMessage", transforms=[fixed]))
        for k in range(12):
            header = bag.header(START + 0.1 * k, "/laser")
            bag.put("/scan", START + 0.1 * k, bag.scan(header, np.array([1.0, 2.0, 3.0]), 0.0, 0.5, (0.1, 5.0)))
    run = imported(tmp_path / "run.bag")
    scan = next(seen.scans["scan"] for seen in run.observations("robot") if seen.scans)
    np.testing.assert_allclose(scan.angles(), [-1.0, -0.5, 0.0], atol=1e-6)
    np.testing.assert_array_equal(scan.ranges, [3.0, 2.0, 1.0])


@pytest.mark.parametrize("form", ["bag", "bag-lz4", "mcap", "mcap-storage"])
def test_a_bag_that_was_cut_is_read_up_to_where_it_ends(form, tmp_path):
    path = tmp_path / ("run.bag" if form.startswith("bag") else "run")
    with new_bag(path, form) as bag:
        for k in range(300):
            header = bag.header(START + 0.1 * k, "laser")
            ranges = np.random.default_rng(k).uniform(1.0, 2.0, 3000)
            bag.put("/scan", START + 0.1 * k, bag.scan(header, ranges, 0.0, 0.002, (0.1, 9.0)))
    whole = path if path.is_file() else next(path.glob("*.mcap"))
    cut = tmp_path / f"cut{whole.suffix}"
    cut.write_bytes(whole.read_bytes()[: int(0.7 * whole.stat().st_size)])
    with RosBag(cut) as bag:
        found = list(bag.messages(["/scan"]))
        assert 60 < len(found) < 300
        assert bag.cut
        assert bag.decode(found[-1]).ranges[0] == np.float32(np.random.default_rng(len(found) - 1).uniform(1.0, 2.0))


@pytest.mark.parametrize("form", ["bag", "sqlite", "mcap"])
def test_a_bag_of_several_files_is_read_without_its_metadata(form, tmp_path):
    folder = tmp_path / "run"
    folder.mkdir()
    for part in range(3):
        one = tmp_path / f"part{part}.bag"
        with new_bag(one, form) as bag:
            # The recorder changes files at different times of each topic.
            for k in range(10 * part, 10 * part + 12):
                header = bag.header(START + 0.1 * k, "laser")
                bag.put(
                    f"/scan{part % 2}", START + 0.1 * k, bag.scan(header, np.full(5, 1.0 + k), 0.0, 0.1, (0.1, 50.0))
                )
                bag.put("/both", START + 0.1 * k, bag.scan(header, np.full(3, 1.0 + k), 0.0, 0.1, (0.1, 50.0)))
        found = one if form == "bag" else next(file for file in one.iterdir() if file.suffix != ".yaml")
        found.rename(folder / f"run_{part}{found.suffix}")
    with RosBag(folder) as bag:
        found = list(bag.messages(["/both", "/scan0"]))
        times = [each.time for each in found]
        assert times == sorted(times)
        ranges = [bag.decode(each).ranges[0] for each in found if each.topic == "/both"]
        assert sorted(ranges) == sorted(1.0 + k for part in range(3) for k in range(10 * part, 10 * part + 12))
        assert bag.counts == {"/scan0": 24, "/scan1": 12, "/both": 36}
    run = imported(folder)
    assert {name for seen in run.observations("robot") for name in seen.scans} == {"both", "scan0", "scan1"}
    some = next(folder.iterdir())
    some.rename(folder / f"other{some.suffix}")
    with pytest.raises(UsageError, match=r"has no metadata\.yaml and 3 files of bags"):
        RosBag(folder)


def test_a_folder_whose_metadata_are_wrong_is_read_by_its_files(tmp_path):
    write_scans(tmp_path / "run")
    told = (tmp_path / "run" / "metadata.yaml").read_text()
    for wrong in (told.replace(".mcap", "_9.mcap"), told[: len(told) // 2], "", "[1, 2"):
        (tmp_path / "run" / "metadata.yaml").write_text(wrong)
        with RosBag(tmp_path / "run") as bag:
            assert len(list(bag.messages(["/scan"]))) == 10
            assert bag.misdescribed
            assert not bag.cut


def test_messages_out_of_order_and_those_of_a_wrong_clock_do_no_harm(tmp_path):
    order = [0, 2, 1, 3, 4, 6, 5, 7, 8, 9]
    with new_bag(tmp_path / "run") as bag:
        for place, k in enumerate(order):
            header = bag.header(START + 0.1 * k, "laser")
            bag.put("/scan", START + 0.1 * place, bag.scan(header, np.full(3, 1.0 + k), 0.0, 0.5, (0.1, 50.0)))
        early = bag.scan(bag.header(17.0, "laser"), np.ones(3), 0.0, 0.5, (0.1, 50.0))
        bag.put("/scan", START + 1.0, early)
        bag.put("/scan", START + 1.1, bag.scan(bag.header(START + 1.0, "laser"), np.ones(4), 0.0, 0.5, (0.1, 50.0)))
    run = imported(tmp_path / "run")
    told = [seen.scans["scan"].ranges[0] for seen in run.observations("robot") if seen.scans]
    assert told == [1.0 + k for k in range(10)]
    assert run.metadata["/scan messages left out"] == "2"


def test_robots_with_namespaces_of_their_own_are_told_apart(tmp_path):
    with new_bag(tmp_path / "run") as bag:
        for k in range(10):
            at = START + 0.1 * k
            for row, name in enumerate(("anna", "bert")):
                pose = Pose3.from_planar(Pose(0.1 * k, float(row), 0.0))
                bag.put(f"/{name}/odom", at, bag.odometry(bag.header(at, "odom"), f"{name}/base_link", pose))
                bag.put(f"/{name}/scan", at, bag.scan(bag.header(at, "l"), np.full(5, row + 1.0), 0.0, 0.5, (0.1, 9.0)))
    run = imported(tmp_path / "run")
    assert set(run.robots) == {"anna", "bert"}
    for row, name in enumerate(("anna", "bert")):
        assert run.robots[name].odometry[-1, 0] == pytest.approx(0.9, abs=1e-6)
        seen = next(seen for seen in run.observations(name) if seen.scans)
        assert set(seen.scans) == {"scan"}
        assert seen.scans["scan"].ranges[0] == row + 1.0
    only = imported(tmp_path / "run", wishes=Wishes(robots=["bert"]))
    assert set(only.robots) == {"bert"}


def test_frames_of_one_name_in_the_tf_of_each_robot_are_not_mixed(tmp_path):
    places = {"anna": 0.1, "bert": 0.9}
    with new_bag(tmp_path / "run") as bag:
        for name, x in places.items():
            hangs = Pose3(x, 0.0, 0.3, 0.0, 0.0, 0.0, 1.0).matrix()
            bag.transforms(f"/{name}/tf_static", START, [("base_link", "laser", hangs)])
        for k in range(5):
            at = START + 0.1 * k
            for name in places:
                still = Pose3.from_planar(Pose(0.0, 0.0, 0.0))
                bag.put(f"/{name}/odom", at, bag.odometry(bag.header(at, "odom"), "base_link", still))
                count = 5 if name == "anna" else 5 - 2 * (k // 3)
                scan = bag.scan(bag.header(at, "laser"), np.full(count, 1.0), 0.0, 0.5, (0.1, 9.0))
                bag.put(f"/{name}/scan", at, scan)
    run = imported(tmp_path / "run")
    assert {robot.name: robot.sensors[0].at for robot in run.world.robots} == {
        name: (x, 0.0, 0.3) for name, x in places.items()
    }
    # What is told of one robot does not hide what is told of the other.
    assert run.metadata["/bert/scan messages left out"] == "2"
    assert run.metadata["anna scan scans left out"] == run.metadata["bert scan scans left out"] == "0"


@pytest.mark.parametrize(
    ("form", "name"),
    [("bag", "run.mcap"), ("mcap", "run.bag"), ("mcap", "RUN.MCAP"), ("sqlite", "run.mcap"), ("bag", "run")],
)
def test_a_bag_is_known_by_what_it_holds_whatever_its_name(form, name, tmp_path):
    first = tmp_path / "first.bag"
    write_scans(first, form)
    file = first if first.is_file() else next(each for each in first.iterdir() if each.name != "metadata.yaml")
    file.rename(tmp_path / name)
    log = imported(tmp_path / name)
    assert sum(len(seen.scans) for seen in log.observations("robot")) > 3
    assert "bag breaks off" not in log.metadata


def test_a_camera_of_an_unknown_encoding_is_left_out_and_reported(tmp_path):
    with new_bag(tmp_path / "seen") as bag:
        for k in range(5):
            header = bag.header(START + 0.1 * k, "eye")
            bag.put("/odom", START + 0.1 * k, bag.odometry(header, "base_link", Pose3(0, 0, 0, 0, 0, 0, 1)))
            bag.put("/eye/image_raw", START + 0.1 * k, bag.image(header, "nv24", np.zeros((16, 16), np.uint8)))
            bag.put("/icon/image_raw", START + 0.1 * k, bag.image(header, "mono8", np.zeros((8, 16), np.uint8)))
    log = imported(tmp_path / "seen")
    assert log.metadata["/eye/image_raw messages left out"] == "5"
    assert log.metadata["icon left out"].startswith("pictures of 16 x 8 pixels; a camera has 16 to 4096")
    assert not log.cameras()


def test_a_log_of_one_moment_is_refused(tmp_path):
    with new_bag(tmp_path / "run") as bag:
        bag.put("/scan", START, bag.scan(bag.header(START, "l"), np.ones(9), 0.0, 0.1, (0.1, 9.0)))
    with pytest.raises(UsageError, match="have the same time; a recording needs at least two ticks"):
        imported(tmp_path / "run")


@pytest.mark.slow
def test_what_cannot_be_read_or_is_not_clear_is_one_line(tmp_path):
    write_scans(tmp_path / "run")
    with new_bag(tmp_path / "two") as bag:
        for topic in ("/wheels", "/fused"):
            pose = Pose3(0, 0, 0, 0, 0, 0, 1)
            bag.put(topic, START, bag.odometry(bag.header(START, "odom"), "base_link", pose))
    with new_bag(tmp_path / "words") as bag:
        bag.put("/chatter", START, bag.make("std_msgs/String", data="hello"))
    with new_bag(tmp_path / "beams") as bag:
        bag.put("/scan", START, bag.scan(bag.header(START, "l"), np.ones(20_000), 0.0, 1e-4, (0.1, 9.0)))
    with new_bag(tmp_path / "nothing") as bag:
        bag.put("/scan", START, bag.scan(bag.header(START, "l"), np.ones(1), 0.0, 1e-4, (0.1, 9.0)))
        bag.put("/odom", START, bag.odometry(bag.header(START, "odom"), "base_link", Pose3(0, 0, 0, 0, 0, 0, 0)))
    with new_bag(tmp_path / "days") as bag:
        for at in (START, START + 1e6, START + 2e6):
            bag.put("/odom", at, bag.odometry(bag.header(at, "odom"), "base_link", Pose3(0, 0, 0, 0, 0, 0, 1)))
    (tmp_path / "empty.bag").write_bytes(b"#ROSBAG V2.0\n")
    (tmp_path / "broken.db3").write_bytes(b"SQLite format 3\x00" + b"\x07" * 5000)
    (tmp_path / "text.bag").write_text("hello")
    for name, topics, said in (
        ("two", {}, "several topics hold odometry: /wheels, /fused; name one with --topic odometry=/wheels"),
        (
            "words",
            {},
            "holds no odometry, scans, clouds, pictures or IMU of ROS; there is nothing to record (it has std_msgs",
        ),
        ("beams", {}, "scans on '/scan' have 20,000 beams; a lidar has at most 10,000"),
        ("nothing", {}, "holds no odometry, scans, clouds, pictures, IMU or sightings; there is nothing to record"),
        (
            "days",
            {},
            "lasts 2000000 s and has 3 readings; a recording of them lasts at most 10300 s: choose a part",
        ),
        ("run", {"scan": ["/skan"]}, "no topic '/skan' in this bag; did you mean '/scan'"),
        ("run", {"lidar": ["/scan"]}, "no kind of topic 'lidar'"),
        (
            "run",
            {"odometry": ["/scan"]},
            "topic '/scan' is of sensor_msgs/msg/LaserScan; odometry is read from nav_msgs",
        ),
        ("empty.bag", {}, "is not a readable bag"),
        ("broken.db3", {}, "is not a readable bag"),
        ("text.bag", {}, "is not a supported log"),
    ):
        with pytest.raises(UsageError, match=re.escape(said)) as caught:
            imported(tmp_path / name, wishes=Wishes(topics=topics))
        assert "\n" not in str(caught.value)
    assert run_command("import-log", tmp_path / "run", "-o", tmp_path / "x.mcap", "--topic", "scan") == 2


def test_commands_echoes_and_what_is_not_read_are_told(tmp_path):
    with new_bag(tmp_path / "run") as bag:
        for k in range(10):
            at = START + 0.1 * k
            bag.put("/odom", at, bag.odometry(bag.header(at, "odom"), "base_link", Pose3(0.01 * k, 0, 0, 0, 0, 0, 1)))
            told = bag.make("geometry_msgs/Twist", linear=bag.xyz(0.3, 0, 0), angular=bag.xyz(0, 0, -0.2))
            bag.put("/cmd_vel", at, told)
            bag.put("/chatter", at, bag.make("std_msgs/String", data="hello"))
            echoes = [bag.make("sensor_msgs/LaserEcho", echoes=np.float32(each)) for each in ([1.0, 2.0], [], [3.0])]
            plain = bag.scan(bag.header(at, "laser"), np.ones(3), 0.0, 0.5, (0.1, 9.0))
            fields = {name: getattr(plain, name) for name in plain.__dataclass_fields__ if not name.startswith("__")}
            bag.put(
                "/most",
                at,
                bag.make("sensor_msgs/MultiEchoLaserScan", **(fields | {"ranges": echoes, "intensities": []})),
            )
    run = imported(tmp_path / "run")
    np.testing.assert_allclose(run.robots["robot"].command[-1], [0.3, 0.0, -0.2])
    scan = next(seen.scans["most"] for seen in run.observations("robot") if seen.scans)
    np.testing.assert_array_equal(scan.ranges, [1.0, np.inf, 3.0])
    assert run.metadata["/chatter left out"] == "10 messages of std_msgs/msg/String"


def test_robots_that_only_tf_tells_apart_are_not_mixed(tmp_path):
    with new_bag(tmp_path / "run") as bag:
        for k in range(10):
            at = START + 0.1 * k
            moved = []
            for row, name in enumerate(("anna", "bert")):
                place = Pose3(0.1 * k, float(row), 0, 0, 0, 0, 1).matrix()
                moved.append(bag.transform(bag.header(at, f"{name}/odom"), f"{name}/base_link", place))
            bag.put("/tf", at, bag.make("tf2_msgs/TFMessage", transforms=moved))
            bag.put("/scan", at, bag.scan(bag.header(at, "l"), np.ones(5), 0.0, 0.5, (0.1, 9.0)))
    run = imported(tmp_path / "run")
    assert run.metadata["odometry"] == "left out: /tf has several frames that move, anna/base_link, bert/base_link"
    assert not run.robots["robot"].odometry[:, :2].any()


def test_an_mcap_that_holds_json_beside_messages_of_ros_is_read_and_kept(tmp_path):
    write_scans(tmp_path / "run")
    (inner,) = (tmp_path / "run").glob("*.mcap")
    mixed = tmp_path / "mixed" / "run.mcap"
    mixed.parent.mkdir()
    with mixed.open("wb") as stream, inner.open("rb") as source:
        reader, writer = make_reader(source), Writer(stream)
        writer.start(profile="ros2")
        other = writer.register_schema("notes.Note", "jsonschema", b"{}")
        note = writer.register_channel("/notes", "json", other)
        kinds: dict[str, int] = {}
        for schema, channel, message in reader.iter_messages():
            if channel.topic not in kinds:
                told = writer.register_schema(schema.name, schema.encoding, schema.data)
                kinds[channel.topic] = writer.register_channel(channel.topic, "cdr", told)
            time = message.log_time
            writer.add_message(kinds[channel.topic], log_time=time, publish_time=time, data=message.data)
            writer.add_message(note, log_time=time, publish_time=time, data=b"{}")
        writer.finish()
    before = mixed.read_bytes()
    run = imported(mixed)
    assert sum(bool(seen.scans) for seen in run.observations("robot")) == 10
    assert run.metadata["/notes left out"].endswith(" messages of notes.Note")
    with pytest.raises(UsageError, match=r"run\.mcap' is a file of the log"):
        mjsim.import_log(mixed.parent, record=mixed, overwrite=True)
    assert mixed.read_bytes() == before


def test_the_beginning_of_a_chunk_that_was_cut_is_read(tmp_path):
    write_scans(tmp_path / "run.bag", form="bag")
    whole = (tmp_path / "run.bag").read_bytes()
    # Connections and their definitions come first, then the messages, then the index.
    part = whole[: whole.index(b"ranges") + (whole.rindex(b"/scan") - whole.index(b"ranges")) * 3 // 4]
    for name, data in (("cut", part), ("zeros", part + bytes(20_000))):
        (tmp_path / f"{name}.bag").write_bytes(data)
        with RosBag(tmp_path / f"{name}.bag") as bag:
            found = list(bag.messages(["/scan"]))
            assert 0 < len(found) < 10
            assert bag.cut


def test_messages_that_zstd_packed_are_read_without_metadata(tmp_path):
    with new_bag(tmp_path / "run", "mcap-message") as bag:
        bag.put("/scan", START, bag.scan(bag.header(START, "laser"), np.arange(3.0), 0.0, 0.1, (0.1, 9.0)))
    (tmp_path / "run" / "metadata.yaml").unlink()
    with RosBag(tmp_path / "run") as bag:
        (found,) = bag.messages(["/scan"])
        assert bag.stamp(found) == pytest.approx(START, abs=1e-6)
        assert bag.decode(found).ranges.tolist() == [0.0, 1.0, 2.0]


def test_scans_of_a_lidar_whose_number_of_beams_varies_are_kept_and_point_where_they_were_measured(tmp_path):
    with new_bag(tmp_path / "run") as bag:
        for k, beams in enumerate([450, 455, 455, 455, 460, 470, 40, 455, 447, 455, 500, 600]):
            at, step = START + 0.1 * k, 2.0 * math.pi / (beams - 1)
            # Each range tells the direction of its beam.
            ranges = 1.0 + step * np.arange(beams)
            bag.put("/scan", at, bag.scan(bag.header(at, "laser"), ranges, 0.0, step, (0.1, 50.0)))
    run = imported(tmp_path / "run")
    scans = [seen.scans["scan"] for seen in run.observations("robot") if seen.scans]
    assert len(scans) == 10
    for scan in scans:
        assert scan.ranges.shape == (455,)
        # Half a beam, of those measured and of those told: nearest beams.
        np.testing.assert_allclose(scan.ranges, 1.0 + scan.angles(), atol=0.51 * 2.0 * math.pi / 446)
    assert run.metadata["/scan messages left out"] == "2"
    assert run.metadata["beams of scan"] == "mended: 5 scans have more or fewer; resampled to 455"
    lines = listed(run)
    assert "kept: lidar 'scan'" in lines
    assert "mended: beams of scan: 5 scans have more or fewer; resampled to 455" in lines
    assert "left out: /scan messages: 2" in lines
    assert any(line.startswith("guessed: place of scan: ") for line in lines)
    fates = [line.partition(":")[0] for line in lines]
    assert fates == sorted(fates, key=["kept", "guessed", "mended", "added", "left out"].index)


@pytest.mark.filterwarnings("error")
def test_a_quaternion_of_huge_numbers_is_no_pose():
    position, turned = SimpleNamespace(x=0.0, y=0.0, z=0.0), SimpleNamespace(x=0.0, y=0.0, z=1e300, w=1e300)
    with pytest.raises(ValueError, match="a pose of numbers"):
        matrix_of(position, turned)
