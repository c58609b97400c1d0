from .world_script import WorldScript as WorldScript
