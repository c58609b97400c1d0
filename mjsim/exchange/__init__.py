"""Worlds in from what people have, and out to what others read.

In: maps of ROS map_server and Nav2. Out: the same.
"""

from mjsim.exchange.maps import explained, world_from_map
from mjsim.exchange.place import with_robot
from mjsim.exchange.raster import write_map

__all__ = ["explained", "with_robot", "world_from_map", "write_map"]
