"""Logs made to harm who reads them: each function writes one into a folder and returns its path."""

import bz2
import gzip
import lzma
import os
import sqlite3
import struct
import tarfile
from collections.abc import Callable, Mapping
from contextlib import closing
from pathlib import Path

import numpy as np
from mcap.writer import CompressionType, Writer
from rosbags.typesys import Stores, get_typestore

from mjsim.geometry import Pose3
from tests.bags import START, Bag, new_bag, write_scans, zstd

ODOM = b"ODOM 0.0 0.0 0.0 0.1 0.0 0.0 1.0 host 1.0\n"
PART = 1 << 20
FILL = b"#" * 1023 + b"\n"
"""A line that says nothing: what matters is how much there is to unpack, not to read."""
TABLE = "log: tables\nodometry: {file: odometry.csv.gz, time: 1, x: 2, y: 3, heading: 4}\n"


def packed(path: Path, line: bytes, megabytes: int) -> Path:
    """Write lines again and again, packed by xz, bz2 or gzip by the file's name: parts that follow one another."""
    pack = {".xz": lzma.compress, ".bz2": bz2.compress, ".gz": gzip.compress}[path.suffix]
    path.write_bytes(pack(line * (PART // len(line))) * megabytes)
    return path


def carmen_bomb(folder: Path) -> Path:
    return packed(folder / "run.log.gz", ODOM + FILL, 100)


def one_line_bomb(folder: Path) -> Path:
    return packed(folder / "run.log.gz", bytes(PART), 100)


def dictionary_of_a_gigabyte(folder: Path) -> Path:
    """Write a file whose decoder remembers 1.5 GB of what it has unpacked."""
    filters = [{"id": lzma.FILTER_LZMA2, "preset": 1, "dict_size": 1536 << 20, "mf": lzma.MF_HC3, "nice_len": 273}]
    packer = lzma.LZMACompressor(lzma.FORMAT_XZ, filters=filters)
    with (folder / "run.log.xz").open("wb") as file:
        file.write(packer.compress(ODOM * 3))
        for _ in range(4):
            file.write(packer.compress(b"# " + bytes(PART - 3) + b"\n"))
        file.write(packer.flush())
    return folder / "run.log.xz"


def mrclam_bomb(folder: Path) -> Path:
    (folder / "Barcodes.dat").write_text("1 5\n6 63\n")
    (folder / "Robot1_Measurement.dat").write_text("1.0 63 1.0 0.0\n")
    packed(folder / "rows.gz", b"1.0 0.0 0.0\n" + FILL, 100).rename(folder / "Robot1_Odometry.dat")
    return folder


def table_bomb(folder: Path) -> Path:
    packed(folder / "odometry.csv.gz", b"1.0,0.0,0.0,0.0\n", 100)
    (folder / "log.yaml").write_text(TABLE)
    return folder / "log.yaml"


def one_line_of_columns(folder: Path) -> Path:
    packed(folder / "odometry.csv.gz", b"1,", 100)
    (folder / "log.yaml").write_text(TABLE)
    return folder / "log.yaml"


def deep_description(folder: Path) -> Path:
    (folder / "log.yaml").write_text("log: tables\nodometry: " + "[" * 20_000 + "\n")
    return folder / "log.yaml"


def many_aliases(folder: Path) -> Path:
    """Write a description in which each level names the one before nine times."""
    levels = ["a0: &a0 [x, x]", *(f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 9)}]" for n in range(1, 12))]
    (folder / "log.yaml").write_text("log: tables\n" + "\n".join(levels) + "\nodometry: *a11\n")
    return folder / "log.yaml"


def outside_by_a_link(folder: Path) -> Path:
    inside = folder / "park"
    inside.mkdir()
    (folder / "secret").write_text("SECRET=1\n")
    (inside / "inputs.dat").symlink_to("../secret")
    (inside / "measurements.dat").write_text("1.0 5.0 1.0 0.3\n")
    return inside


def pipe_for_a_table(folder: Path) -> Path:
    os.mkfifo(folder / "inputs.dat")
    return folder


def pipe_for_a_list(folder: Path) -> Path:
    os.mkfifo(folder / "rgb.txt")
    return folder


def pipe_for_euroc(folder: Path) -> Path:
    (folder / "mav0" / "cam0").mkdir(parents=True)
    os.mkfifo(folder / "mav0" / "cam0" / "data.csv")
    return folder


def links_in_a_circle(folder: Path) -> Path:
    (folder / "a").symlink_to("b")
    (folder / "b").symlink_to("a")
    (folder / "rgb.txt").symlink_to("a")
    return folder


def _bag(folder: Path, message: Callable[[Bag, float], tuple[str, object]], form: str = "mcap") -> Path:
    """Write a bag of odometry and two messages of another kind."""
    with new_bag(folder / "bag", form) as bag:
        for k in range(3):
            at = START + 0.1 * k
            bag.put("/odom", at, bag.odometry(bag.header(at, "odom"), "base_link", Pose3(0.1 * k, 0, 0, 0, 0, 0, 1)))
            topic, content = message(bag, at)
            bag.put(topic, at, content)
    return folder / "bag"


def bag_with_a_picture_of_claims(folder: Path) -> Path:
    def make(bag: Bag, at: float) -> tuple[str, object]:
        picture = bag.image(bag.header(at, "c"), "mono8", np.zeros((2, 2), dtype=np.uint8))
        picture.width = picture.height = picture.step = 0xFFFFFFFF
        return "/camera/image_raw", picture

    return _bag(folder, make)


def bag_with_a_cloud_of_claims(folder: Path) -> Path:
    """Write points that take no bytes, four thousand million of them."""

    def make(bag: Bag, at: float) -> tuple[str, object]:
        cloud = bag.cloud(bag.header(at, "l"), np.zeros((1, 1), dtype=[(n, "<f4") for n in "xyz"]))
        cloud.width, cloud.height, cloud.point_step, cloud.row_step = 1, 0xFFFFFFFF, 12, 0
        return "/points", cloud

    return _bag(folder, make)


def bag_with_rvl_of_claims(folder: Path) -> Path:
    """Write depth that claims 40,000 x 40,000 pixels."""
    data = struct.pack("<iff", 0, 0.0, 0.0) + struct.pack("<II", 40_000, 40_000) + bytes([0x8F] * 400)
    form = "16UC1; compressedDepth rvl"
    return _bag(folder, lambda bag, at: ("/d/compressedDepth", bag.compressed(bag.header(at, "c"), form, data)))


def bag_with_scans_of_claims(folder: Path) -> Path:
    def make(bag: Bag, at: float) -> tuple[str, object]:
        scan = bag.scan(bag.header(at, "l"), np.ones(9), -1.0, 1e-38, (0.1, 3e38))
        scan.time_increment = scan.scan_time = float("inf")
        return "/scan", scan

    return _bag(folder, make)


def mcap_of_bombs(folder: Path) -> Path:
    """Write a chunk of 80 MB in a file of some kB."""
    with (folder / "run.mcap").open("wb") as file:
        writer = Writer(file, compression=CompressionType.ZSTD, chunk_size=1 << 31)
        writer.start("ros2", "")
        channel = writer.register_channel(
            "/camera/compressed", "cdr", writer.register_schema("sensor_msgs/msg/CompressedImage", "ros2msg", b"")
        )
        store = get_typestore(Stores.LATEST)
        made = Bag(None, store, ros1=False)
        message = made.compressed(made.header(START, "c"), "png", bytes(40 << 20))
        data = bytes(store.serialize_cdr(message, message.__msgtype__))
        for k in range(2):
            writer.add_message(channel, k * 10**8, data, k * 10**8)
        writer.finish()
    return folder / "run.mcap"


def _record(header: Mapping[str, bytes], data: bytes) -> bytes:
    """Return a record of a bag of ROS 1."""
    fields = b"".join(
        struct.pack("<I", len(name) + 1 + len(value)) + name.encode() + b"=" + value for name, value in header.items()
    )
    return struct.pack("<I", len(fields)) + fields + struct.pack("<I", len(data)) + data


def bag_of_bombs(folder: Path) -> Path:
    """Write a bag of ROS 1 whose chunks unpack to 100 MB each."""
    packer = bz2.BZ2Compressor(9)
    packed = b"".join([*(packer.compress(bytes(PART)) for _ in range(100)), packer.flush()])
    size = struct.pack("<I", 100 << 20)
    chunk = _record({"op": b"\x05", "compression": b"bz2", "size": size}, packed)
    head = _record({"op": b"\x03", "index_pos": bytes(8), "conn_count": bytes(4), "chunk_count": bytes(4)}, b" " * 4027)
    (folder / "run.bag").write_bytes(b"#ROSBAG V2.0\n" + head + chunk * 3)
    return folder / "run.bag"


def bag_with_an_index_of_itself(folder: Path) -> Path:
    """Write a bag of ROS 1 whose index begins at its own first record and counts four thousand million entries."""
    write_scans(folder / "run.bag", "bag")
    data = bytearray((folder / "run.bag").read_bytes())
    for name in (b"index_pos=", b"conn_count=", b"chunk_count="):
        place = data.index(name) + len(name)
        data[place : place + 4] = struct.pack("<I", 13 if name == b"index_pos=" else 0xFFFFFFFF)
    (folder / "run.bag").write_bytes(data)
    return folder / "run.bag"


def bag_whose_chunks_are_one(folder: Path) -> Path:
    """Write a bag of ROS 1 in which the index names the first chunk for all."""
    write_scans(folder / "run.bag", "bag")
    data = (folder / "run.bag").read_bytes()
    place = data.index(b"chunk_pos=") + len(b"chunk_pos=")
    (folder / "run.bag").write_bytes(data[:place] + struct.pack("<Q", 13) + data[place + 8 :])
    return folder / "run.bag"


def _sqlite(folder: Path, script: str) -> Path:
    path = folder / "run.db3"
    kind = "nav_msgs/msg/Odometry"
    with closing(sqlite3.connect(path)) as database:
        database.executescript(
            "CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);"
            "INSERT INTO schema VALUES (4, 'rolling');"
            "CREATE TABLE metadata(id INTEGER PRIMARY KEY, metadata_version INTEGER, metadata TEXT);"
            "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT,"
            " offered_qos_profiles TEXT, type_description_hash TEXT);"
            "CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT, encoding TEXT,"
            " encoded_message_definition TEXT, type_description_hash TEXT);"
            f"INSERT INTO topics VALUES (1, '/odom', '{kind}', 'cdr', '', '');" + script
        )
        database.commit()
    return path


COUNT = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n)"


def messages_without_end(folder: Path) -> Path:
    """Write a view in place of the table of messages, whose rows never end."""
    view = f"CREATE VIEW messages AS {COUNT} SELECT i AS id, i AS rowid, 1 AS topic_id, i AS timestamp, x'00' AS data"
    return _sqlite(folder, f"{view} FROM n;")


def topics_without_end(folder: Path) -> Path:
    columns = "i AS id, 't' || i AS name, 'a/msg/B' AS type, 'cdr' AS serialization_format"
    view = f"CREATE VIEW topics AS {COUNT} SELECT {columns}, '' AS offered_qos_profiles FROM n;"
    table = "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB);"
    return _sqlite(folder, f"DROP TABLE topics; {view} {table}")


def messages_of_a_gigabyte(folder: Path) -> Path:
    """Write a view whose rows hold a thousand million zeros each."""
    rows = "SELECT i AS id, 1 AS topic_id, i * 1000 AS timestamp, zeroblob(999000000) AS data FROM n LIMIT 9"
    return _sqlite(folder, f"CREATE VIEW messages AS {COUNT} {rows};")


def metadata_of_aliases(folder: Path) -> Path:
    write_scans(folder / "run", "sqlite")
    levels = ["a0: &a0 [x, x]", *(f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 9)}]" for n in range(1, 12))]
    (folder / "run" / "metadata.yaml").write_text("\n".join(levels) + "\nrosbag2_bagfile_information: *a11\n")
    return folder / "run"


def metadata_of_brackets(folder: Path) -> Path:
    write_scans(folder / "run", "sqlite")
    (folder / "run" / "metadata.yaml").write_text("rosbag2_bagfile_information: " + "[" * 20_000)
    return folder / "run"


def metadata_names_others(folder: Path) -> Path:
    """Write metadata whose file lies outside the bag."""
    write_scans(folder / "other", "sqlite")
    write_scans(folder / "run", "sqlite")
    text = (folder / "run" / "metadata.yaml").read_text().replace("run.db3", "../other/other.db3")
    (folder / "run" / "metadata.yaml").write_text(text)
    (folder / "run" / "run.db3").unlink()
    return folder / "run"


def packed_database_bomb(folder: Path) -> Path:
    write_scans(folder / "run", "sqlite-file")
    (file,) = (folder / "run").glob("*.zstd")
    file.write_bytes(zstd.compress(b"SQLite format 3\x00" + bytes(100 << 20)))
    return folder / "run"


def archive(folder: Path) -> Path:
    with tarfile.open(folder / "run.tar", "w") as tar:
        link = tarfile.TarInfo("../../outside")
        link.type, link.linkname = tarfile.SYMTYPE, "/etc"
        tar.addfile(link)
    return folder / "run.tar"


def stamps_past_all_numbers(folder: Path) -> Path:
    rows = ["1e308", "nan", "inf", "-1e308", "1.5e308"]
    (folder / "run.log").write_text("".join(f"ODOM {x} 0 0 {x} 0 0 {x} h {x}\n" for x in rows))
    return folder / "run.log"


def ranges_past_all_numbers(folder: Path) -> Path:
    scan = "FLASER 3 1e308 1e308 1e308 1e308 1e308 1e308 1e308 1e308 1e308 {t} h {t}\n"
    (folder / "run.log").write_text("".join(scan.format(t=t) for t in (1.0, 2.0, 3.0)))
    return folder / "run.log"


def numbers_of_a_million_digits(folder: Path) -> Path:
    digits = "1" * 900_000
    (folder / "run.log").write_text(f"FLASER {digits} 1 0 0 0 0 0 0 1 h 1\n" * 9)
    return folder / "run.log"


HOSTILE: Mapping[str, Callable[[Path], Path]] = {
    name: each
    for name, each in globals().items()
    if callable(each)
    and getattr(each, "__module__", "") == __name__
    and name not in ("packed",)
    and not name.startswith("_")
}
