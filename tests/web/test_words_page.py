"""The visible words of the page: in one table, looked up by key, and another language in their place in a browser."""

import re
from pathlib import Path

import pytest
from playwright.sync_api import expect

import mjsim
from tests.windows import page_at

SOURCES = Path(mjsim.__file__).parent / "web" / "page" / "src"
MOVED = ["main.ts", *(f"{part}/*.ts" for part in ("charts", "edit", "panel", "plan", "review", "run", "shell"))]
"""What has its words in the table; `scene`, a program of its own, and `text` still have some in place."""
LATER = {"shell/document.ts", "shell/history.ts", "shell/naming.ts"}
"""Names of undo steps are put together from verbs that their own code reads."""
LITERAL = re.compile(r"""//[^\n]*|/\*.*?\*/|("(?:[^"\\\n]|\\.)*"|`(?:[^`\\]|\\.)*`)""", re.DOTALL)
NOT_SEEN = re.compile(
    r"(\b(class|role|at|font|style|viewBox|method|view|kind)|className|from|FONT|KEY|FIRST|clip"
    r"|[!=]==|case|import|word\(|matchMedia\(|includes\(|offers\(|querySelector\w*(<\w+>)?\(|el\()[:=]? *(\w+ \? )?$"
)
WORDS = re.compile(r"^[A-Z][a-z]+( |$)|[A-Za-z]{2,}[,.;:]? [a-z]{2,}")


PLAIN = re.compile(
    r"mjsim studio|<\?xml|run-chart |(Alt|Ctrl|Page) [^a-z]|system-ui|:is\(|/api/|^.Hz|\$\{(Object|plain)\b"
)
"""The program's name, markup, classes, fonts, addresses, units, and names of keys, which keyboards show so."""


def visible(text):
    """Return the literals that read like words for people, with their lines."""
    found = [match for match in LITERAL.finditer(text) if match[1]]
    plain = [(text.count("\n", 0, each.start()) + 1, each[1], text[: each.start()][-50:]) for each in found]
    return [
        (line, said)
        for line, said, before in plain
        if WORDS.search(said[1:-1]) and not PLAIN.search(said) and not NOT_SEEN.search(before)
    ]


def test_no_visible_words_stand_outside_the_table():
    files = [path for pattern in MOVED for path in sorted(SOURCES.glob(pattern))]
    files = [path for path in files if path.relative_to(SOURCES).as_posix() not in LATER]
    assert len(files) > 100
    left = [f"{path.name}:{line}: {said}" for path in files for line, said in visible(path.read_text("utf-8"))]
    assert left == []


def test_each_key_of_the_table_is_used_and_has_words():
    table = dict(
        re.findall(r'^  "([\w.]+)":\s+"(.*)",$', (SOURCES / "words" / "en.ts").read_text("utf-8"), re.MULTILINE)
    )
    used = {
        key for path in SOURCES.rglob("*.ts") for key in re.findall(r'"([a-z]+\.[A-Za-z]\w*)"', path.read_text("utf-8"))
    }
    assert set(table) <= used  # that each has words, the types say
    assert all(table.values())


@pytest.mark.slow
def test_another_language_takes_the_place_of_english(browser, studio):
    with page_at(browser, studio.url) as page:
        expect(page.get_by_role("tab", name="Review", exact=True)).to_be_visible()
        assert page.evaluate("document.documentElement.lang") == "en"
        page.evaluate("localStorage.setItem('mjsim-language', 'en-XA')")
        page.reload()
        expect(page.get_by_role("tab", name="[Révíéw~]", exact=True)).to_be_visible()
        assert page.evaluate("document.documentElement.lang") == "en-XA"
        page.get_by_role("button", name="[Kéys (?)~]").or_(page.get_by_title("[Kéys (?)~]")).first.click()
        keys = page.get_by_role("dialog", name="[Kéys~]")
        expect(keys).to_contain_text("[ópén á wórld~]")
        assert [text for text in keys.locator("span").all_inner_texts() if not text.startswith("[")] == []
