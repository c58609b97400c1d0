"""The interface of modules: the values they receive and return, and their protocols.

Metres, seconds and radians. The robot's frame has x ahead and y to the left, its origin on the floor at its drive's
center of rotation. Nothing here holds the truth; a module senses what a robot of that kind would sense.
"""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
