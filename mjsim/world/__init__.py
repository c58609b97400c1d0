"""The world file: text to a frozen, validated `World`, and back without losing a comment."""

from mjsim.world.model import World
from mjsim.world.reader import load_world, parse_world

__all__ = ["World", "load_world", "parse_world"]
