"""JSON Schema of the world file, so that editors complete keys and mark mistakes."""

from typing import Any

from mjsim.world.model import World


def world_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of a world file, descriptions and defaults with it."""
    schema = World.model_json_schema()
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema, "title": "mjsim world"}
