from .import_scene import bring_scene as bring_scene
from .import_scene import is_scene as is_scene
