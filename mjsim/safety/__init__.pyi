from .bump import react_to_bump as react_to_bump
from .ring import RingAvoidance as RingAvoidance
