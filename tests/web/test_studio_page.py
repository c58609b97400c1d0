import hashlib
import json
import re
import tomllib
from pathlib import Path

import pytest

import mjsim.web

WEB = Path(mjsim.web.__file__).parent
PAGE, STATIC = WEB / "page", WEB / "static"
PACKED = {"index.html", "studio.js", "scene.js", "languages.js", "studio.css", "LICENSES.txt"}
BESIDE = ("build.mjs", "index.html", "package.json", "package-lock.json", "tsconfig.json")


@pytest.mark.parametrize("name", ["studio.js", "scene.js", "languages.js", "studio.css"])
def test_the_bundle_was_made_from_the_sources_beside_it(name):
    sources = {path.relative_to(PAGE).as_posix(): path for path in (PAGE / "src").rglob("*") if path.is_file()}
    digest = hashlib.sha256()
    for source, path in sorted((sources | {name: PAGE / name for name in BESIDE}).items()):
        data = path.read_bytes()
        digest.update(f"{source} {len(data)}\n".encode() + data)
    first = (STATIC / name).read_text(encoding="utf-8").partition("\n")[0]
    assert first == f"/* sources {digest.hexdigest()} */", "run scripts/make/page and commit what it makes"


def test_the_page_is_the_one_beside_the_sources():
    assert (STATIC / "index.html").read_bytes() == (PAGE / "index.html").read_bytes()


def test_the_bundle_is_small_and_loads_nothing_from_elsewhere():
    style = (STATIC / "studio.css").read_text(encoding="utf-8")
    programs = [(STATIC / name).read_text(encoding="utf-8") for name in ("studio.js", "scene.js")]
    assert all(len(program) < 1_000_000 for program in programs)
    assert not re.search(r"(@import|url\()\s*['\"]?(https?:)?//", style)
    for program in programs:
        assert not re.search(r"(fetch|import|Worker|WebSocket)\(\s*['\"](https?:)?//", program)


def test_the_page_begins_without_what_draws_in_3d():
    program, scene = ((STATIC / name).read_text(encoding="utf-8") for name in ("studio.js", "scene.js"))
    assert "WebGLRenderer" in scene
    assert "WebGLRenderer" not in program


def test_the_licences_of_what_is_bundled_go_along():
    texts = (STATIC / "LICENSES.txt").read_text(encoding="utf-8")
    bundled = json.loads((PAGE / "package.json").read_text(encoding="utf-8"))["dependencies"]
    assert all(f"\n{name} {version}\n" in texts for name, version in bundled.items())
    assert texts.count("Permission is hereby granted") >= len(bundled)


def test_a_package_has_the_bundle_and_not_its_sources():
    settings = tomllib.loads((WEB.parents[1] / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["setuptools"]
    assert settings["exclude-package-data"]["mjsim.web"] == ["page/**"]
    assert {path.name for path in STATIC.iterdir()} == PACKED


def test_the_libraries_of_the_page_stand_at_exact_versions_and_name_no_registry():
    manifest = json.loads((PAGE / "package.json").read_text(encoding="utf-8"))
    versions = [*manifest["dependencies"].values(), *manifest["devDependencies"].values()]
    assert all(re.fullmatch(r"\d+\.\d+\.\d+", version) for version in versions)
    assert "resolved" not in (PAGE / "package-lock.json").read_text(encoding="utf-8")


@pytest.mark.parametrize("scheme", [":root {", ':root[data-theme="dark"] {'])
def test_text_stands_out_from_what_it_stands_on_as_wcag_asks(scheme):
    style = (PAGE / "src" / "ui" / "theme.css").read_text(encoding="utf-8")
    colors = dict(re.findall(r"--([\w-]+): (#[0-9a-f]{6});", style.partition(scheme)[2].partition("}")[0]))
    grounds = [colors[name] for name in ("page", "paper", "raised")]
    for name in ("ink", "muted", "accent", "error", "warning", "code-key", "code-text", "code-number", "code-note"):
        assert min(contrast(colors[name], ground) for ground in grounds) >= 4.5, name
    for name, ground in (("on-accent", "accent"), ("accent", "accent-soft"), ("error", "error-soft")):
        assert contrast(colors[name], colors[ground]) >= 4.5, name
    for name in ("edge", "accent", "truth", "estimate", "wall"):  # outlines of controls and what plans are read by
        assert min(contrast(colors[name], ground) for ground in grounds) >= 3.0, name


def contrast(one: str, other: str) -> float:
    """WCAG 2.2, "contrast ratio"."""
    light, dark = sorted((luminance(one), luminance(other)), reverse=True)
    return (light + 0.05) / (dark + 0.05)


def luminance(color: str) -> float:
    """WCAG 2.2, "relative luminance"."""
    shares = [value / 255 for value in bytes.fromhex(color.removeprefix("#"))]
    red, green, blue = (share / 12.92 if share <= 0.04045 else ((share + 0.055) / 1.055) ** 2.4 for share in shares)
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def test_the_page_is_sent_compressed_to_whom_takes_that(client):
    plain = client.get("/studio.js", headers={"accept-encoding": "identity"})
    packed = client.get("/studio.js", headers={"accept-encoding": "gzip"})
    assert packed.headers["content-encoding"] == "gzip"
    assert packed.content == plain.content == (STATIC / "studio.js").read_bytes()
    assert int(packed.headers["content-length"]) < 0.4 * len(plain.content)
