"""Add words to mjsim/web/page/src/words/en_fields.ts for fields and forms of the world file that have none there.

    python scripts/make/words.py

The words are made from the key, as the page itself does: edit them where English says it otherwise, and add their
translations. Words that are there stay.
"""

import json
import re
from pathlib import Path

from mjsim.web.edit.panel_schema import panel_schema

TABLE = Path(__file__).resolve().parents[2] / "mjsim" / "web" / "page" / "src" / "words" / "en_fields.ts"
ENTRY = re.compile(r'^  "((?:field|form)\.\w+)": +"(.*)",\n', re.MULTILINE)


def wanted() -> set[str]:
    """Return the keys of all fields, without their units, and of all forms that a value may have."""
    schema = panel_schema()
    kinds = schema["$defs"]
    fields = {key for kind in (schema, *kinds.values()) for key in kind.get("properties", {})}
    unions = re.findall(r'"(?:any|one)Of": (\[.*?\])', json.dumps(schema))
    forms = {name for union in unions for name in re.findall(r"#/\$defs/(\w+)", union)}
    objects = {form for form in forms if kinds[form].get("type") == "object"}
    return {f"field.{re.sub('_(deg|hz)$', '', key)}" for key in fields} | {f"form.{form}" for form in objects}


def with_words(text: str) -> str:
    """Return the table with words for all keys, in alphabetical order."""
    entries = dict(ENTRY.findall(text))
    for key in wanted() - entries.keys():
        entries[key] = re.sub("([a-z])([A-Z])", r"\1 \2", key.partition(".")[2]).replace("_", " ").capitalize()
    first, *_, last = ENTRY.finditer(text)
    lines = "".join(f'  "{key}": "{words}",\n' for key, words in sorted(entries.items()))
    return text[: first.start()] + lines + text[last.end() :]


if __name__ == "__main__":
    TABLE.write_text(with_words(TABLE.read_text(encoding="utf-8")), encoding="utf-8")
