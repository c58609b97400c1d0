"""The schema of worlds from which the page builds its fields and hints."""

import json
from functools import cache

from mjsim.web.worlds import Json
from mjsim.world import with_units, worlds_folder


@cache
def panel_schema() -> Json:
    """Return the schema of the text of worlds, with the unit of each field.

    It is read from the file beside the shipped worlds: generating it from the models takes most of a second.
    """
    return with_units(json.loads((worlds_folder() / "mjsim.schema.json").read_text(encoding="utf-8")))


@cache
def schema_text() -> bytes:
    """Return the schema as JSON."""
    return json.dumps(panel_schema(), ensure_ascii=False, separators=(",", ":")).encode()
