"""What user modules meet: the values that they get and give, and the protocols that they follow.

Metres, seconds and radians. The robot's frame has x ahead and y to the left, its origin on the floor where
its drive turns about. Nothing here holds the truth; a module senses what a robot of that kind would sense.
"""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
