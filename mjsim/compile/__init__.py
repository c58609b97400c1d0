"""World -> MuJoCo: a scene in memory, or a folder that plain MuJoCo loads."""

from mjsim.compile.export import export_scene
from mjsim.compile.scene import compile_world

__all__ = ["compile_world", "export_scene"]
