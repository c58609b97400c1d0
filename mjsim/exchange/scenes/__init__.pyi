from .bring import bring_scene as bring_scene
from .bring import is_scene as is_scene
