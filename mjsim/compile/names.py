"""Names of items in the compiled scene."""

from mjsim.world.names import item_names

__all__ = ["item_names"]
