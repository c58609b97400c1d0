"""mjsim: a simulator for navigation and SLAM of indoor wheeled robots, with rendered camera images.

Everything public is here: `import mjsim`, then `mjsim.load_world`, `mjsim.Simulation`, `mjsim.run` and so on.
"""

from importlib import import_module

from mjsim.faces import face
from mjsim.gl_request import hide_request_from_mujoco
from mjsim.traces import shorten_traces
from mjsim.views import Viewed

hide_request_from_mujoco()  # Before anything imports mujoco.
shorten_traces()
Viewed._views = staticmethod(lambda: import_module("mjsim.notebook"))

# A name loads its module when it is first used, so that `import mjsim` stays quick; `__init__.pyi` says which.
__getattr__, __dir__, __all__ = face(__name__, __file__)
