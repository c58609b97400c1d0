"""mjsim: a simulator for navigation and SLAM of indoor wheeled robots, with rendered camera images.

Everything public is here: `import mjsim`, then `mjsim.load_world`, `mjsim.Simulation`, `mjsim.run` and so on.
"""

from mjsim.faces import face
from mjsim.gl_request import hide_request_from_mujoco

hide_request_from_mujoco()  # Before anything imports mujoco.

# A name loads its module when it is first used, so that `import mjsim` stays quick; `__init__.pyi` says which.
__getattr__, __dir__, __all__ = face(__name__, __file__)
