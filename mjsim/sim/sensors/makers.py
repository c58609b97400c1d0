"""Device class of each kind of sensor."""

from mjsim.sim.sensors.beacons import BeaconDevice
from mjsim.sim.sensors.camera import CameraDevice
from mjsim.sim.sensors.compass import CompassDevice
from mjsim.sim.sensors.device import Makers
from mjsim.sim.sensors.encoders import EncoderDevice
from mjsim.sim.sensors.imu import ImuDevice
from mjsim.sim.sensors.lidar3d import Lidar3dDevice
from mjsim.sim.sensors.rotating_lidar import lidar_device
from mjsim.sim.sensors.uwb import UwbDevice
from mjsim.world import sensors

MAKERS: Makers = {
    sensors.Camera: CameraDevice,
    sensors.Lidar: lidar_device,
    sensors.BeaconSensor: BeaconDevice,
    sensors.Imu: ImuDevice,
    sensors.Encoders: EncoderDevice,
    sensors.Uwb: UwbDevice,
    sensors.Lidar3d: Lidar3dDevice,
    sensors.Compass: CompassDevice,
}
"""Factory of the device of each kind of sensor."""
