"""Sensors one can buy: their presets, keys over them, and how they are written."""

import pytest

from mjsim.errors import WorldError
from mjsim.sim import Simulation
from mjsim.world import Camera, Lidar, format_world, parse_world
from mjsim.world.items.sensing.sensor_presets import sensor_names

KINDS = {"lidar": Lidar, "camera": Camera}


def world(sensors: str):
    return parse_world(f"mjsim: 1\nrobots: [{{name: r, at: [0, 0], sensors: [{sensors}]}}]\n")


@pytest.mark.parametrize(("kind", "name"), [(kind, name) for kind in KINDS for name in sensor_names(kind)])
def test_every_preset_is_a_sound_sensor_that_senses_at_25_ticks_a_second(kind, name):
    built = world(f"{{{kind}: one, preset: {name}}}")
    assert isinstance(built.robots[0].sensors[0], KINDS[kind])
    with Simulation(built) as sim:
        assert sim.robots["r"].sensors["one"].kind == kind
        if kind == "lidar":
            assert len(sim.sense("r").scans["one"].ranges) == built.robots[0].sensors[0].beams


def test_a_key_beside_a_preset_hides_that_of_the_preset():
    sensor = world("{lidar: scan, preset: lds-01, range: [0.2, 3.0], at: [0, 0, 0.2]}").robots[0].sensors[0]
    assert (sensor.beams, sensor.fov_deg, sensor.range, sensor.rate_hz) == (360, 360.0, (0.2, 3.0), 5.0)


def test_a_preset_that_is_not_there_is_named_with_one_that_is():
    with pytest.raises(WorldError, match="no lidar preset 'lds01'; did you mean 'lds-01'"):
        world("{lidar: scan, preset: lds01}")


def test_a_sensor_of_a_preset_is_written_short_and_reads_back_equal():
    # 180 beams are what a lidar has by itself, and no preset has.
    before = world("{lidar: scan, preset: sick-lms111, beams: 180, yaw_deg: 5}, {camera: c, preset: realsense-d435}")
    built = before.model_copy()
    built._source = type(before.source)()
    text = format_world(built)
    assert parse_world(text) == before
    assert "preset: sick-lms111" in text
    assert "beams: 180" in text
    assert "0.012" not in text
