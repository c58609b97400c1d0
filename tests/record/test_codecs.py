"""What a new kind of reading may forget: a codec for its field, a codec and a device for its kind of sensor."""

from dataclasses import fields

from mjsim.interface import Observation
from mjsim.record.readings import CODECS
from mjsim.sim.sensors import MAKERS
from mjsim.world.items import SENSOR_KINDS


def test_every_field_of_an_observation_is_recorded():
    assert {codec.field for codec in CODECS} == {each.name for each in fields(Observation)} - {"time", "dt"}


def test_every_kind_of_sensor_has_a_device_and_a_codec():
    kinds = set(SENSOR_KINDS)
    assert {model.kind for model in MAKERS} == kinds
    assert {codec.sensor for codec in CODECS} - {None} == kinds
