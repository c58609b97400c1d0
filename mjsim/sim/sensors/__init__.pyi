from .camera import OnboardCamera as OnboardCamera
from .camera import robot_from_camera as robot_from_camera
from .device import FastDevice as FastDevice
from .device import Mounting as Mounting
from .makers import MAKERS as MAKERS
from .places import lidar_places as lidar_places
from .suite import Sensors as Sensors
from .suite import ticks_between as ticks_between
