"""Hashes of types against those that ROS 2 Jazzy publishes."""

import pytest
from rosbags.interfaces import Nodetype

from mjsim.ros import service_hash, type_hash


@pytest.mark.parametrize(
    ("kind", "known"),
    [
        ("sensor_msgs/msg/LaserScan", "64c191398013af96509d518dac71d5164f9382553fce5c1f8cca5be7924bd828"),
        ("std_msgs/msg/String", "df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"),
        ("std_srvs/srv/msg/Trigger_Request", "eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f"),
        ("std_srvs/srv/msg/Trigger_Response", "eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f"),
    ],
)
def test_types_have_the_hashes_that_ros_publishes(kind, known):
    assert type_hash(kind) == f"RIHS01_{known}"


def test_a_service_with_fields_has_the_hash_that_ros_publishes():
    numbers = [(name, (Nodetype.BASE, ("int64", 0))) for name in ("a", "b", "sum")]
    found = service_hash("example_interfaces/srv/AddTwoInts", request=numbers[:2], response=numbers[2:])
    assert found == "RIHS01_e118de6bf5eeb66a2491b5bda11202e7b68f198d6f67922cf30364858239c81a"
