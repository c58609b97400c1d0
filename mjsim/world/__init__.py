"""The world file: text to a frozen, validated `World`, and back without losing a comment."""

from mjsim.world.check import check_world
from mjsim.world.model import World
from mjsim.world.reader import load_checked, load_world, parse_world
from mjsim.world.schema import editor_schema, world_schema
from mjsim.world.writer import format_world

__all__ = [
    "World",
    "check_world",
    "editor_schema",
    "format_world",
    "load_checked",
    "load_world",
    "parse_world",
    "world_schema",
]
