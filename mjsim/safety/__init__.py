"""What keeps a robot whole: the reaction to a bump, always on, and the built-in obstacle avoidance."""

from mjsim.safety.bump import react_to_bump
from mjsim.safety.ring import RingAvoidance

__all__ = ["RingAvoidance", "react_to_bump"]
