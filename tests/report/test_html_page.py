"""Result pages are made of blocks of text, none of which can be taken for HTML."""

from html.parser import HTMLParser
from typing import get_args

from mjsim.report.html_page import Block, Code, Heading, HtmlPicture, HtmlTable, Items, Paragraph, html_page

EVIL = """<script>"alert('x')"</script>&amp;"""


class Seen(HTMLParser):
    """The tags, and the texts and attributes that hold the evil one as it is written."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.tags, self.evil = [], 0
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.evil += sum(value == EVIL for _, value in attrs)

    def handle_data(self, data):
        self.evil += EVIL in data


def test_every_block_shows_what_it_was_given_and_none_of_it_is_html():
    blocks = [
        Heading(EVIL),
        Paragraph(EVIL, EVIL),
        Items([EVIL]),
        Code(EVIL),
        HtmlTable((EVIL,), [(EVIL, (EVIL, EVIL))], kind=EVIL),
        HtmlPicture(EVIL, EVIL, captioned=True),
    ]
    assert {type(block) for block in blocks} == set(get_args(Block))
    seen = Seen(html_page(EVIL, EVIL, *blocks))
    assert "script" not in seen.tags
    # Of the title two, with the command; then in the order of the blocks.
    assert seen.evil == 2 + 1 + 2 + 1 + 1 + 5 + 3


def test_a_head_without_text_is_a_plain_cell_and_a_wide_table_scrolls_with_keys():
    page = html_page("room", "mjsim", HtmlTable(("", "mean"), [("a", "1")], wide=True))
    assert "<thead><tr><td></td><th>mean</th></tr></thead>" in page
    assert '<div class="wide" tabindex="0"><table>' in page
