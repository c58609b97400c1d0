"""World -> MuJoCo: a scene in memory, or a folder that plain MuJoCo loads."""

from mjsim.compile.export import export_scene
from mjsim.compile.obstacles import check_models
from mjsim.compile.scene import compile_world

__all__ = ["check_models", "compile_world", "export_scene"]
