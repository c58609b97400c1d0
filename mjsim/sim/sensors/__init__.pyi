from .camera import OnboardCamera as OnboardCamera
from .camera import robot_from_camera as robot_from_camera
from .device import FastDevice as FastDevice
from .device import Mounting as Mounting
from .lidar_poses import lidar_places as lidar_places
from .makers import MAKERS as MAKERS
from .suite import Sensors as Sensors
from .suite import ticks_between as ticks_between
