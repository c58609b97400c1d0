"""Poses of the lidars of a world, for drawing their measurements."""

import numpy as np

from mjsim.compile import robot_from_sensor
from mjsim.geometry import Array
from mjsim.world import World, name_of, sensors


def lidar_places(world: World) -> dict[str, Array]:
    """Return robot_from_sensor of each lidar by 'ROBOT/LIDAR', shape (4, 4) [m]; those on moving arms are left out."""
    return {
        f"{robot.name}/{name_of(sensor)}": np.asarray(
            robot_from_sensor(sensor.at, yaw_deg=sensor.yaw_deg, pitch_deg=sensor.pitch_deg)
        )
        for robot in world.robots
        for sensor in robot.sensors
        if isinstance(sensor, sensors.Lidar | sensors.Lidar3d) and sensor.on is None
    }
