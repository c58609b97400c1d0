"""Settings of the documentation site, which `scripts/make/site` builds with Sphinx."""

import dataclasses
import gc
import importlib.metadata
import re
import sys
from pathlib import Path
from typing import Any, get_type_hints

from sphinx.application import Sphinx
from sphinx.ext.napoleon import Config, GoogleDocstring

from mjsim import interface, record

sys.path.insert(0, str(Path(__file__).parent / "site"))
gc.disable()  # it would take a fifth of the time of a build, for nothing: the trees of all pages are kept

project = "mjsim"
author = "the authors of mjsim"
copyright = "the authors of mjsim, Apache-2.0"
release = importlib.metadata.version("mjsim")

extensions = ["myst_parser", "sphinx.ext.autodoc", "command_line"]
exclude_patterns = ["site"]
templates_path = ["site/templates"]

myst_heading_anchors = 4
myst_enable_extensions = ["colon_fence"]

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
autodoc_default_options = {"members": True, "undoc-members": False}
autoclass_content = "class"
python_maximum_signature_line_length = 88
python_use_unqualified_type_names = True
add_module_names = False


html_theme = "pydata_sphinx_theme"
html_title = f"mjsim {release}"
html_show_sourcelink = False
html_copy_source = False
html_static_path = ["site/static"]
html_css_files = ["mjsim.css"]
html_theme_options = {
    "navbar_align": "left",
    "header_links_before_dropdown": 6,
    "show_prev_next": False,
    "show_toc_level": 2,
    "navbar_end": ["versions", "theme-switcher"],
    "footer_start": ["copyright"],
    "footer_end": ["theme-version"],
    "pygments_light_style": "a11y-high-contrast-light",
    "pygments_dark_style": "a11y-high-contrast-dark",
    "back_to_top_button": False,
}


def _google_style(app: Sphinx, what: str, name: str, obj: object, options: object, lines: list[str]) -> None:
    """Turn a docstring into what Sphinx reads: `code`, and sections such as Args; a field has no sections."""
    lines[:] = re.sub("(?<!`)`([^`]+)`(?!`)", r"``\1``", "\n".join(lines)).split("\n")
    if what not in ("attribute", "data", "property"):
        lines[:] = GoogleDocstring(lines, Config(napoleon_use_rtype=False), app, what, name, obj, options).lines()


def _examples() -> dict[str, tuple[str, str]]:
    """Return the code of each class in `site/examples.py`, after the first class of its heading, which shows it."""
    text = (Path(__file__).parent / "site" / "examples.py").read_text(encoding="utf-8")
    found = re.findall(r"^# %% ([^\n]+)\n(.*?)(?=^# %% |\Z)", text, re.MULTILINE | re.DOTALL)
    return {name: (names.split(", ")[0], code.strip()) for names, code in found for name in names.split(", ")}


EXAMPLES = _examples()


def _with_example(app: Sphinx, what: str, name: str, obj: object, options: object, lines: list[str]) -> None:
    """Add the example of a class of `mjsim`; classes that share one refer to the first of them."""
    first, code = EXAMPLES.get(name.removeprefix("mjsim."), ("", ""))
    if what not in ("class", "exception") or not first:
        return
    if name != f"mjsim.{first}":
        lines += ["", f"Example: see :class:`mjsim.{first}`."]
        return
    lines += ["", ".. rubric:: Example", "", ".. code-block:: python", ""]
    lines += [f"    {line}" for line in code.split("\n")]


def _short_signature(app: Sphinx, what: str, name: str, obj: Any, *others: object) -> tuple[str, str | None] | None:
    """Return the names of the fields of a dataclass; types and meanings follow, field by field; protocols have none."""
    if getattr(obj, "_is_protocol", False):
        return "", None
    if what != "class" or not dataclasses.is_dataclass(obj):
        return None
    names = [f"{each.name}{'' if _is_needed(each) else '=...'}" for each in dataclasses.fields(obj)]
    return f"({', '.join(names)})", None


def _is_needed(field: dataclasses.Field[Any]) -> bool:
    return field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING


def _types_without_forms() -> None:
    """Leave out of the types of readings what recordings, not readers, need: `Annotated[Odometry, Form(...)]`."""
    assert record.codec_of  # it reads these types when it is imported
    for kind in (getattr(interface, name) for name in interface.__all__):
        if dataclasses.is_dataclass(kind) and "Form(" in str(kind.__annotations__):
            plain = {name: get_type_hints(kind)[name] for name in kind.__annotations__}
            kind.__annotations__ = plain


def setup(app: Sphinx) -> None:
    """Connect what reads docstrings."""
    _types_without_forms()
    app.connect("autodoc-process-signature", _short_signature)
    app.connect("autodoc-process-docstring", _google_style)
    app.connect("autodoc-process-docstring", _with_example)
