from .landmarks import SPEED as SPEED
from .landmarks import read_landmarks as read_landmarks
from .landmarks import world_from_landmarks as world_from_landmarks
