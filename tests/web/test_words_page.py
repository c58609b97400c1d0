"""The visible words of the page: in one table, looked up by key, and another language in their place in a browser."""

import json
import re
import runpy
from pathlib import Path

import pytest
from playwright.sync_api import expect

import mjsim
from mjsim.web import Studio
from tests.windows import PATIENCE, page_at

SOURCES = Path(mjsim.__file__).parent / "web" / "page" / "src"
WORDS_MAKER = runpy.run_path(str(Path(mjsim.__file__).parents[1] / "scripts" / "make" / "words.py"))
WORLD = """\
mjsim: 1
walls: [{points: [[-3, -3], [3, -3]]}]
obstacles: [{name: crate, box: [1, 1, 1], at: [1, -1]}]
beacons: [{name: poster, image: posters/lion.jpg, at: [2.9, 0], heading_deg: 180}]
robots: [{name: scout, preset: pioneer3dx, at: [0, 0]}]
people: [{name: eve, sex: female, at: [1, 2]}]
run: {seconds: 1, drivers: {scout: {navigator: {use: "mjsim.algorithms.waypoints:Waypoints", points: [[1, 0]]}}}}
"""
NOT_FOR_PEOPLE = {"text/look.ts", "text/phrases.ts", "scene/strokes.ts", "scene/ribbons.ts", "plan/roles.ts"}
"""Style sheets, names of roles, keys by which a library asks for words, and programs for the graphics processor."""
LITERAL = re.compile(r"""//[^\n]*|/\*.*?\*/|("(?:[^"\\\n]|\\.)*"|`(?:[^`\\]|\\.)*`)""", re.DOTALL)
NOT_SEEN = re.compile(
    r"(\b(class|role|at|font|style|viewBox|method|view|kind)|className|from|FONT|KEY|FIRST|clip"
    r"|[!=]==|case|import|word\(|definition\(|matchMedia\(|includes\(|offers\(|querySelector\w*(<\w+>)?\(|el\()"
    r"[:=]? *([a-z][\w.]+ \? )?$"
)
WORDS = re.compile(r"^[A-Z][a-z]+([ ;]|$)|[A-Za-z]{2,}[,.;:]? [a-z]{2,}|\} [a-z]{2,}|[a-z]{2,}:? \$\{")


PLAIN = re.compile(
    r"mjsim studio|my_slam|<\?xml|run-chart |^.(Alt|Ctrl|Page) [^a-z]|system-ui|:is\(|/api/|^.Hz|\$\{(Object|plain)\b"
    r"|^.(Pair|Item|Key|Literal|Tab|Escape|Arrow)"  # nodes of a parsed text, keys of a keyboard
    r"|(swatch|reset|remove|form|key|suggest|add( \$\{title\})?|group).$"  # marks
    r"|on its way|the scene has no root"  # and our own fault
)
"""The program's name, markup, classes, fonts, addresses, units, and names of keys, which keyboards show so."""


SPOKEN = re.compile(r'>([^<>]+)<|\b(?:title|alt|placeholder|aria-(?:label|description))="([^"]+)"')
"""Texts of a template, and attributes that people see or hear."""


def closing(text, k):
    """Return where the code of a value in a template ends, which begins at `k`."""
    while text[k] != "}":
        if text[k] == "{":
            k = closing(text, k + 1)
        elif text[k] == "`":
            k = template(text, k + 1)[1]
        elif text[k] == '"':
            k = re.compile(r'"(?:[^"\\]|\\.)*"').match(text, k).end() - 1
        k += 1
    return k


def template(text, k):
    """Return the markup of a template that begins at `k`, its values as NUL; where it ends; and their code."""
    markup, values = "", []
    while text[k] != "`":
        if text.startswith("${", k):
            end = closing(text, k + 2)
            values.append(text[k + 2 : end])
            markup, k = f"{markup}\0", end
        else:
            markup += text[k]
        k += 1
    return markup, k, values


def without_markup(text):
    """Return code with the words of its templates as strings, and their values as code."""
    before, found, after = text.partition("html`")
    if not found:
        return text
    markup, end, values = template(after, 0)
    words = [f'"{" ".join((said or heard).split())}"' for said, heard in SPOKEN.findall(markup)]
    code = ", ".join(map(without_markup, values)) + "\n" * markup.count("\n")
    return f"{before}[{code}, {', '.join(words)}]{without_markup(after[end + 1 :])}"


def test_words_of_templates_are_found_and_their_markup_is_none():
    source = 'html`<b class="run to" title="Go on">Stop it\n${a ? html`<i>${word("x.y")} now is</i>` : "no way"}</b>`;'
    assert sorted(said.strip('"\0 ') for _, said in visible(source)) == ["Go on", "Stop it", "no way", "now is"]


def visible(source):
    """Return the literals that read like words for people, with their lines."""
    text = without_markup(source)
    found = [match for match in LITERAL.finditer(text) if match[1]]
    plain = [(text.count("\n", 0, each.start()) + 1, each[1], text[: each.start()][-50:]) for each in found]
    return [
        (line, said)
        for line, said, before in plain
        if WORDS.search(said[1:-1]) and not PLAIN.search(said) and not NOT_SEEN.search(before)
    ]


def test_no_visible_words_stand_outside_the_table():
    files = {path.relative_to(SOURCES).as_posix(): path for path in sorted(SOURCES.rglob("*.ts"))}
    seen = {name: path for name, path in files.items() if name not in NOT_FOR_PEOPLE and not name.startswith("words/")}
    assert len(seen) > 130
    left = [f"{name}:{line}: {said}" for name, path in seen.items() for line, said in visible(path.read_text("utf-8"))]
    assert left == []


def test_each_field_and_form_of_the_language_has_words_of_the_table():
    """A label that is in no table would stay English in every language."""
    assert len(WORDS_MAKER["wanted"]()) > 400
    table = WORDS_MAKER["TABLE"].read_text("utf-8")
    assert table == WORDS_MAKER["with_words"](table)
    assert all(words for _, words in WORDS_MAKER["ENTRY"].findall(table))


def test_each_key_of_the_table_is_used_and_has_words():
    table = dict(
        re.findall(r'^  "([\w.]+)":\s+"(.*)",$', (SOURCES / "words" / "en.ts").read_text("utf-8"), re.MULTILINE)
    )
    used = {
        key for path in SOURCES.rglob("*.ts") for key in re.findall(r'"([a-z]+\.[A-Za-z]\w*)"', path.read_text("utf-8"))
    }
    assert set(table) <= used  # that each has words, the types say
    assert all(table.values())


TABLE = re.compile(r'^  "([\w.]+)":\s+"(.*)",$', re.MULTILINE)


def table_of(*names):
    """Return the entries of tables by key."""
    return dict(pair for name in names for pair in TABLE.findall((SOURCES / "words" / name).read_text("utf-8")))


def test_translations_are_whole_and_have_the_values_of_the_english_table():
    own = {"en.ts", "en_fields.ts", "en_server.ts"}
    english = table_of(*own)
    others = (
        {path.name for path in (SOURCES / "words").glob("*.ts")} - own - {"words.ts", "languages.ts", "sentences.ts"}
    )
    for name in others:
        translated = table_of(name)
        assert translated.keys() == english.keys(), name
        for key, text in translated.items():
            assert text
            assert sorted(re.findall(r"\{\w+\}", text)) == sorted(re.findall(r"\{\w+\}", english[key])), key


@pytest.mark.slow
def test_a_language_is_chosen_by_address_and_menu_and_kept(browser, tmp_path):
    (tmp_path / "room.yaml").write_text(WORLD)
    with Studio(tmp_path, world="room.yaml") as studio, page_at(browser, studio.url) as page:
        expect(page.get_by_role("tab", name="Review", exact=True)).to_be_visible()
        page.goto(page.url.split("#")[0] + "?lang=en-XA#edit")
        expect(page.get_by_role("tab", name="[Révíéw~]", exact=True)).to_be_visible()
        assert page.evaluate("document.documentElement.lang") == "en-XA"
        assert "lang" not in page.url
        page.get_by_role("treeitem").filter(has_text="crate").first.click()
        expect(page.locator('.panel .label[title^="[Whéthér á róbót cán púsh ít"]')).to_have_count(1)
        page.reload()
        expect(page.get_by_role("tab", name="[Rún~]", exact=True)).to_be_visible()
        page.get_by_role("button", name="[Lángúágé~]").click()
        page.get_by_role("menuitemradio", name="English", exact=True).click()
        expect(page.get_by_role("tab", name="Review", exact=True)).to_be_visible()
        page.reload()
        expect(page.get_by_role("tab", name="Review", exact=True)).to_be_visible()
        assert page.evaluate("document.documentElement.lang") == "en"
        who_reads_a_language_that_the_page_lacks_is_given_english_and_no_choice(browser, studio.url)


def who_reads_a_language_that_the_page_lacks_is_given_english_and_no_choice(browser, url):
    with browser.new_context(locale="de-DE") as context:
        page = context.new_page()
        page.goto(url)
        expect(page.get_by_role("tab", name="Review", exact=True)).to_be_visible(timeout=PATIENCE)
        assert page.evaluate("navigator.language") == "de-DE"
        expect(page.get_by_role("button", name="Language")).to_have_count(0)


SHOWN = """() => [...document.querySelectorAll("body *")].flatMap((one) => {
  // The text of the world has its own words, keyboards have theirs.
  if (one.closest(".cm-content, kbd, script, noscript")) return [];
  if (!one.checkVisibility({ visibilityProperty: true })) return [];
  const texts = [...one.childNodes].filter((node) => node.nodeType === Node.TEXT_NODE).map((node) => node.data);
  for (const pseudo of ["::before", "::after"]) texts.push(getComputedStyle(one, pseudo).content);
  return [...texts, ...["aria-label", "title", "placeholder"].map((name) => one.getAttribute(name) ?? "")];
})"""
DATA = re.compile(
    r"^/[\w./\[\]]+$|^mjsim\.\w+$|^-?[\d.]+ (s|deg|px)$|^(mjsim|NEES)$|^[\w/-]+\.(mcap|yaml|jpg)$|√|sqrt|^sense$"
)
"""Fields of a recording, numbers with units, names of files, and the name of a time that is measured."""


LISTEN = """() => {
  const { fetch } = window;
  window.told = [];
  window.fetch = async (...request) => {
    const response = await fetch(...request);
    if (/json/.test(response.headers.get("content-type"))) window.told.push(await response.clone().text());
    return response;
  };
}"""


class Told:
    """All strings that the server has told a page: names, keys of worlds, and what the schema says of them."""

    def __init__(self, page) -> None:
        self._page = page
        self._strings: set[str] = set()
        self._judged: set[str] = set()

    def unmoved(self) -> list[str]:
        """Return what the page shows of words that neither its table nor the data has, and did not show before."""
        for text in self._page.evaluate("window.told.splice(0)"):
            self._add(json.loads(text))
        shown = {text.strip() for text in self._page.evaluate(SHOWN) if re.search("[A-Za-z]{2}", text)}
        new = {text for text in shown if "~]" not in text} - self._judged
        self._judged |= new
        return sorted(text for text in new if not self._is_data(text))

    def _add(self, value) -> None:
        if isinstance(value, str) and value not in self._strings:
            self._strings.update([value, value.strip(), letters(value), *re.split(r"[/:.]\s?", value)])
        for inner in [*value, *value.values()] if isinstance(value, dict) else value if isinstance(value, list) else []:
            self._add(inner)

    def _is_data(self, text: str) -> bool:
        """Whether the server told a text; labels of fields are words of the table."""
        known = self._strings
        if DATA.search(text) or text in known:
            return True
        if len(text) > 10 and any(each.startswith(letters(text)) for each in known):
            return True
        parts = re.sub(r" \[.*?\]", "", text).split(", ")
        return all(part in known or any(each.startswith(f"{part.lower()}_") for each in known) for part in parts)


def letters(text):
    """Return a text without what stands in brackets and without all that is no letter."""
    return re.sub(r"\[.*?\]|[^A-Za-z]", "", text)


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """A folder with a world and two runs of it."""
    place = tmp_path_factory.mktemp("words")
    (place / "flat.yaml").write_text(WORLD)
    for seed in (1, 2):
        with mjsim.Simulation(mjsim.load_world(place / "flat.yaml"), seed=seed) as sim:
            mjsim.run(sim, record=place / f"run{seed}.mcap")
    return place


@pytest.mark.slow
def test_every_view_and_dialog_shows_words_of_the_table_and_of_the_data_only(browser, runs):
    left: list[str] = []
    with Studio(runs, world="flat.yaml") as studio, page_at(browser, studio.url, own=True) as page:
        page.add_init_script(f"({LISTEN})()")
        page.evaluate("localStorage.setItem('mjsim-language', 'en-XA')")
        page.reload()
        told = Told(page)
        for state in walked(page):
            left += [f"{state}: {text}" for text in told.unmoved()]
    assert left == []


def walked(page):
    """Go through the views and their dialogs as a person would; yield the name of each state."""

    def press(name):
        page.get_by_role("button", name=name, exact=True).locator("visible=true").first.click()

    def tab(view, name):
        page.locator(view).get_by_role("tab", name=name, exact=True).click()

    expect.set_options(timeout=PATIENCE)
    expect(page.locator("#view-edit .plan")).to_have_attribute("data-view", re.compile(","))
    expect(page.locator(".panel h2")).to_be_visible()
    yield "Edit"
    for thing in ("scout", "poster", "eve", "crate", "[wáll 1~]"):
        page.locator(".outline-name", has_text=thing).click()
        expect(page.locator(".panel h2")).to_have_text(thing)
        yield thing
    page.locator(".plan").focus()
    page.keyboard.press("Control+a")
    page.keyboard.press("Shift+F10")
    expect(page.get_by_role("menu")).to_be_visible()
    yield "several and their menu"
    page.keyboard.press("Escape")
    page.keyboard.press("Control+d")
    page.get_by_role("button", name="[Úndó stéps~]").click()
    expect(page.get_by_role("menuitemradio")).to_have_count(2)
    yield "steps"
    page.keyboard.press("Escape")
    page.keyboard.press("Control+z")
    for key in ("?", "Control+o"):
        page.keyboard.press(key)
        expect(page.get_by_role("dialog")).to_be_visible()
        yield f"dialog of {key}"
        page.keyboard.press("Escape")
    press("[Néw wórld~]")
    expect(page.get_by_role("dialog")).to_be_visible()
    yield "new world"
    page.keyboard.press("Escape")
    page.locator(".cm-content").click()
    page.keyboard.press("Control+f")
    expect(page.locator(".cm-search")).to_be_visible()
    yield "search in the text"
    page.keyboard.press("Alt+2")
    expect(page.locator("#view-run .run-setup select").first).to_be_visible()
    yield "Setup"
    press("[Stárt~]")
    expect(page.locator("#view-run .run-chart:not(.unknown)").first).to_be_visible()
    for each in page.locator("#view-run [role=tab]:visible").all():
        each.click()
        yield f"Run, {each.inner_text()}"
    page.keyboard.press("Alt+3")
    page.locator("[data-path='run1.mcap']").click()
    expect(page.locator(".run-time:visible")).to_contain_text("0.96")
    for each in page.locator("#view-review [role=tab]:visible").all():
        each.click()
        yield f"Review, {each.inner_text()}"
    page.locator("#view-review [role=tab]").first.click()
    for seed in (1, 2):
        page.locator(f"input[aria-label*='run{seed}.mcap']").check()
    page.get_by_role("button", name=re.compile("Cómpáré 2")).click()
    expect(page.locator(".compare .run-chart:not(.unknown)").first).to_be_visible()
    yield "Compare"
