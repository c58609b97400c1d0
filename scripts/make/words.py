"""Add words to mjsim/web/page/src/words/en_fields.ts for fields and forms of the world file that have none there.

    python scripts/make/words.py [--sentences]

The words are made from the key, as the page itself does: edit them where English says it otherwise, and add their
translations. Words that are there stay. With `--sentences`, the sentences of the server and of world files are printed
instead, as JSON: those that a whole language has.
"""

import ast
import json
import re
import sys
from collections.abc import Iterator
from pathlib import Path

from mjsim.sentences import plain
from mjsim.web.edit.panel_schema import panel_schema

ROOT = Path(__file__).resolve().parents[2] / "mjsim"
TABLE = ROOT / "web" / "page" / "src" / "words" / "en_fields.ts"
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


def sentences() -> set[str]:
    """Return the templates of all sentences with values, and all errors without."""
    found = set()
    for path in sorted(ROOT.rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        if "Sentence" not in text and "Error(" not in text:
            continue
        for node in ast.walk(ast.parse(text)):
            name = getattr(node.func, "id", "") if isinstance(node, ast.Call) else ""
            if isinstance(node, ast.Call) and (name == "Sentence" or name.endswith(("Error", "Event", "Problem"))):
                texts = [each.value for arg in node.args for each in _parts(arg) if isinstance(each, ast.Constant)]
                found |= {text for text in texts if isinstance(text, str) and " " in text}
    return {plain(text) for text in found if re.search("[a-z]{2}", text)}


def _parts(node: ast.AST) -> Iterator[ast.AST]:
    yield node
    for child in ast.iter_child_nodes(node):
        if not isinstance(child, ast.JoinedStr):
            yield from _parts(child)


if __name__ == "__main__" and sys.argv[1:] == ["--sentences"]:
    print(json.dumps(sorted(sentences()), indent=1, ensure_ascii=False))
elif __name__ == "__main__":
    TABLE.write_text(with_words(TABLE.read_text(encoding="utf-8")), encoding="utf-8")
