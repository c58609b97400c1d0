from .landmarks import WAYPOINT_SPEED as WAYPOINT_SPEED
from .landmarks import read_landmarks as read_landmarks
from .landmarks import world_from_landmarks as world_from_landmarks
