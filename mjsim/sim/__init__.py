"""The simulation: owns MuJoCo's model and state; drives, sensors, pictures and contact."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
