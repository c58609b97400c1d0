import hashlib
import re
from pathlib import Path

import pytest

import mjsim.web

WEB = Path(mjsim.web.__file__).parent
PAGE, STATIC = WEB / "page", WEB / "static"
BESIDE = ("build.mjs", "index.html", "package.json", "package-lock.json", "tsconfig.json")


@pytest.mark.parametrize("name", ["studio.js", "studio.css"])
def test_the_bundle_was_made_from_the_sources_beside_it(name):
    sources = {path.relative_to(PAGE).as_posix(): path for path in (PAGE / "src").rglob("*") if path.is_file()}
    digest = hashlib.sha256()
    for source, path in sorted((sources | {name: PAGE / name for name in BESIDE}).items()):
        data = path.read_bytes()
        digest.update(f"{source} {len(data)}\n".encode() + data)
    first = (STATIC / name).read_text(encoding="utf-8").partition("\n")[0]
    assert first == f"/* sources {digest.hexdigest()} */", "run scripts/build-page and commit what it makes"


def test_the_page_is_the_one_beside_the_sources():
    assert (STATIC / "index.html").read_bytes() == (PAGE / "index.html").read_bytes()


def test_the_bundle_is_small_and_loads_nothing_from_elsewhere():
    program = (STATIC / "studio.js").read_text(encoding="utf-8")
    style = (STATIC / "studio.css").read_text(encoding="utf-8")
    assert len(program) < 1_000_000
    assert not re.search(r"(@import|url\()\s*['\"]?(https?:)?//", style)
    assert not re.search(r"(fetch|import|Worker|WebSocket)\(\s*['\"](https?:)?//", program)


def test_the_libraries_of_the_page_stand_at_exact_versions_and_name_no_registry():
    manifest = (PAGE / "package.json").read_text(encoding="utf-8")
    versions = re.findall(r'^    "(?!check|build)[@\w/-]+": "([^"]+)"', manifest, re.M)
    assert len(versions) > 5
    assert all(re.fullmatch(r"\d+\.\d+\.\d+", version) for version in versions)
    assert "resolved" not in (PAGE / "package-lock.json").read_text(encoding="utf-8")
